# The one definition of the environment. Stage `environment` is what ./in-env runs commands in (it sees
# the repository by mounts). The last stage carries the program itself and runs as an ordinary user; what
# tests, types and debugging need, and what only compiles C++, is not in it.
#   docker build -t rockslip .                                  podman build, buildah bud: the same
#   docker build -t rockslip:sid --build-arg SUITE=sid .        dolfinx of Debian unstable
ARG SUITE=trixie
FROM debian:${SUITE}-slim AS environment
ARG SUITE

# The release file of a mirror may be older than its validity: that is not a reason to stop here.
# OpenBLAS: the reference BLAS of a minimal Debian makes factorizations 3 to 8 times slower.
# xvfb, xauth: Debian's VTK draws through an X server, also off screen.
RUN echo 'Acquire::Check-Valid-Until "false";' > /etc/apt/apt.conf.d/90valid-until \
 && apt-get update \
 && DEBIAN_FRONTEND=noninteractive apt-get install -y --no-install-recommends \
        python3-dolfinx-real python3-gmsh python3-petsc4py-real python3-mpi4py \
        python3-numpy python3-scipy python3-numba python3-pyvista python3-matplotlib \
        python3-tqdm python3-tomli-w \
        libopenblas0-pthread openmpi-bin libopenmpi-dev g++ libc6-dev pkg-config \
        python3-dev python3-pip python3-setuptools python3-wheel \
        python3-pytest python3-pytest-xdist python3-hypothesis python3-mypy \
        libgl1 libglx-mesa0 xvfb xauth fonts-dejavu-core \
        git make \
 && rm -rf /var/lib/apt/lists/*

# More ranks than cores are allowed, and not bound to any. The keys and their file have other names in
# the mpirun of Debian unstable, which complains of the old ones.
RUN if [ -e /etc/prrte/prte-mca-params.conf ]; \
    then printf 'mapby = :oversubscribe\nbindto = none\n' >> /etc/prrte/prte-mca-params.conf; \
    else printf 'rmaps_default_mapping_policy = :oversubscribe\nhwloc_default_binding_policy = none\n' \
            >> /etc/openmpi/prte-mca-params.conf; fi

# One BLAS thread a rank; ranks that wait give way to others; a container may be entered as root; ranks
# of one machine talk through shared memory (tcp finds no interface in a container and says so), without
# reading each other's memory, which a container may forbid.
ENV LANG=C.UTF-8 \
    OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 \
    OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 \
    OMPI_MCA_btl=self,sm OMPI_MCA_smsc=^cma OMPI_MCA_mpi_yield_when_idle=1 \
    PYTHONNOUSERSITE=1 PYVISTA_OFF_SCREEN=true MPLBACKEND=Agg \
    ROCKSLIP_SUITE=${SUITE}

# In this stage `rockslip` is the program of the mounted repository (PYTHONPATH).
RUN printf '#!/bin/sh\nexec python3 -m rockslip "$@"\n' > /usr/local/bin/rockslip \
 && chmod +x /usr/local/bin/rockslip

# What a user's runs do without. Forms of finite elements are compiled from C: gcc, Python's headers and
# those of ffcx stay. Packages that depend on one that goes are told to do without it.
#   libamdhip64, libamd-comgr2, libllvm17: graphics cards of AMD, for UCX' own benchmark alone
#   libboost, libicu-dev, cmake, g++, gfortran: what builds DOLFINx, not what it needs to run
FROM environment AS trimmed
RUN dpkg-query -W -f='${Package}\n' \
    | grep -E -x 'valgrind(-mpi|-dbg)?|python3-(mypy|hypothesis|pytest|pytest-xdist|execnet)|libc6-dbg|git|git-man|\
libamdhip64-.*|libamd-comgr.*|libllvm17.*|llvm-19.*|libjs-mathjax|cmake|cmake-data|\
libboost.*-dev|libicu-dev|g[+][+].*|gfortran.*|libgfortran-[0-9]+-dev|libstdc[+][+]-[0-9]+-dev|\
libssl-dev|libfftw3-dev|liblapack-dev|libmumps-dev|libhypre-dev|libeigen3-dev|libhdf5-.*dev|libptscotch-dev|\
libscotch-dev|libsuitesparse-dev|libslepc-.*-dev|libsuperlu-.*dev|libpmix-dev|.*-doc' \
    | xargs dpkg --purge --force-depends \
 && find /usr/lib/*-linux-gnu -maxdepth 1 -name '*.a' ! -name 'libc_nonshared.a' -delete \
 && find /usr/share/doc ! -type d ! -name copyright -delete \
 && rm -rf /var/cache/apt/* /var/log/* /usr/lib/debug /usr/share/man /usr/share/info /usr/share/locale

# One layer of what is left: files that a later layer removes would still be carried along.
FROM scratch AS program
ARG SUITE=trixie
COPY --from=trimmed / /
# As in stage `environment`: a stage from scratch takes no variables over.
ENV LANG=C.UTF-8 \
    OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 \
    OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 \
    OMPI_MCA_btl=self,sm OMPI_MCA_smsc=^cma OMPI_MCA_mpi_yield_when_idle=1 \
    PYTHONNOUSERSITE=1 PYVISTA_OFF_SCREEN=true MPLBACKEND=Agg \
    ROCKSLIP_SUITE=${SUITE}

COPY . /opt/rockslip
# The home folder is open to every user: with `--user $(id -u)` the caches are written there too.
# Times of files in whole seconds: layers of images keep no others, and numba goes by them.
RUN rm /usr/local/bin/rockslip \
 && pip install --no-deps --no-build-isolation --no-cache-dir --break-system-packages \
        --root-user-action=ignore /opt/rockslip \
 && rm -rf /opt/rockslip/build /opt/rockslip/*.egg-info \
 && useradd --create-home rockslip \
 && find /opt/rockslip -exec touch -d "@$(date +%s)" {} + \
 && chmod 1777 /home/rockslip
# Two studies and demos/hertz take what they need from benchmarks/ of the repository.
# Machine code is for any processor of this kind, and made here, as the forms of finite elements are.
ENV HOME=/home/rockslip PYTHONPATH=/opt/rockslip NUMBA_CPU_NAME=generic
USER rockslip
WORKDIR /home/rockslip
RUN python3 -m solver.run.warming && chmod -R a+rwX .cache
CMD ["rockslip"]
