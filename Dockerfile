# The one definition of the environment. Stage `environment` is what ./in-env runs commands in (it sees
# the repository by mounts). The last stage carries the program itself and runs as an ordinary user; what
# tests, types and debugging need, and what only compiles C++, is not in it.
#   docker build -t rockslip .                                  podman build, buildah bud: the same
#   docker build -t rockslip:sid --build-arg SUITE=sid .        dolfinx of Debian unstable
ARG SUITE=trixie
FROM debian:${SUITE}-slim AS environment
ARG SUITE

# What packages bring along and nothing here reads is not unpacked: two fifths of their files, a third of their size.
# Documents and languages; what only builds or debugs C++ (Boost's headers, static libraries, LLVM's programs, Valgrind);
# graphics cards of AMD. What gcc itself links, and its empty stand-ins for old names, stays.
RUN printf 'path-exclude=%s\n' \
        '/usr/share/doc/*' '/usr/share/man/*' '/usr/share/info/*' '/usr/share/locale/*' \
        '/usr/share/javascript/mathjax/*' '/usr/include/boost/*' '/usr/lib/*.a' \
        '/usr/lib/llvm-*/bin/*' '/usr/lib/debug/*' '/usr/libexec/valgrind/*' '/usr/include/valgrind/*' \
        '/usr/lib/*/libLLVM-17.so*' '/usr/lib/*/libamdhip64.so*' '/usr/lib/*/libamd_comgr.so*' \
        > /etc/dpkg/dpkg.cfg.d/unread \
 && printf 'path-include=%s\n' \
        '/usr/share/doc/*/copyright' '/usr/share/locale/locale.alias' '/usr/lib/gcc/*' \
        '/usr/lib/*/libc_nonshared.a' '/usr/lib/*/libdl.a' '/usr/lib/*/libpthread.a' '/usr/lib/*/librt.a' \
        >> /etc/dpkg/dpkg.cfg.d/unread

# The release file of a mirror may be older than its validity: that is not a reason to stop here.
# OpenBLAS: the reference BLAS of a minimal Debian makes factorizations 3 to 8 times slower.
# xvfb, xauth: Debian's VTK draws through an X server, also off screen.
RUN echo 'Acquire::Check-Valid-Until "false";' > /etc/apt/apt.conf.d/90valid-until \
 && apt-get update \
 && DEBIAN_FRONTEND=noninteractive apt-get install -y --no-install-recommends \
        python3-dolfinx-real python3-gmsh python3-petsc4py-real python3-mpi4py \
        python3-numpy python3-scipy python3-pyvista python3-matplotlib \
        python3-tqdm python3-tomli-w python3-h5py \
        libopenblas0-pthread openmpi-bin libopenmpi-dev g++ libc6-dev pkg-config cmake make \
        python3-dev python3-pip python3-setuptools python3-scikit-build-core \
        python3-pytest python3-pytest-xdist python3-hypothesis python3-mypy \
        libgl1 libglx-mesa0 xvfb xauth fonts-dejavu-core \
        git \
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
    | grep -E -x -e 'valgrind(-mpi|-dbg)?|libc6-dbg|git|git-man|cmake|cmake-data|libjs-mathjax|fonts-mathjax|.*-doc' \
        -e 'python3-(mypy|mypy-extensions|hypothesis|pytest|pytest-xdist|execnet|pip|wheel|scikit-build-core)' \
        -e 'python3-(pathspec|pyproject-metadata)' \
        -e 'libamdhip64-.*|libamd-comgr.*|libllvm17.*|llvm-[0-9].*|g[+][+].*|gfortran.*|libgfortran-[0-9]+-dev|libstdc[+][+]-[0-9]+-dev' \
        -e 'lib(boost|icu|ssl|fftw3|lapack|blas|mumps|hypre|eigen3|hdf5|ptscotch|scotch|suitesparse|slepc|superlu|pmix|gnutls28).*-dev' \
    | xargs dpkg --purge --force-depends \
 && find /usr/lib/*-linux-gnu -maxdepth 1 -name '*.a' ! -name 'libc_nonshared.a' -delete \
 && find /usr/share/doc ! -type d ! -name copyright -delete \
 && rm -rf /var/cache/apt/* /var/log/* /usr/lib/debug /usr/share/man /usr/share/info /usr/share/locale

# The compiled kernels: solver/kernels/build.sh has the command.
FROM environment AS kernels
COPY solver/kernels /kernels
RUN /kernels/build.sh /kernels/librockslip.so

# One layer of what is left: files that a later layer removes would still be carried along.
FROM scratch AS program
ARG SUITE
COPY --from=trimmed / /
# As in stage `environment`: a stage from scratch takes no variables over. The home folder is open to every
# user: with `--user $(id -u)` caches go there, too.
ENV LANG=C.UTF-8 \
    OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 \
    OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 \
    OMPI_MCA_btl=self,sm OMPI_MCA_smsc=^cma OMPI_MCA_mpi_yield_when_idle=1 \
    PYTHONNOUSERSITE=1 PYVISTA_OFF_SCREEN=true MPLBACKEND=Agg \
    ROCKSLIP_SUITE=${SUITE}
ENV PATH=/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin \
    HOME=/home/rockslip PYTHONPATH=/opt/rockslip
# -P: a file of the user's folder is not taken for a module of the program.
RUN useradd --create-home rockslip && chmod 1777 /home/rockslip \
 && sed -i 's/python3 -m/python3 -P -m/' /usr/local/bin/rockslip
COPY rockslip.py /opt/rockslip/
COPY geometry /opt/rockslip/geometry
COPY solver /opt/rockslip/solver
COPY --from=kernels /kernels/librockslip.so /opt/rockslip/solver/kernels/
RUN python3 -m compileall -q /opt/rockslip
USER rockslip
WORKDIR /home/rockslip
# Forms of finite elements and the list of fonts, which every container would make anew.
RUN python3 -m solver.run.warming \
 && python3 -c 'import matplotlib.font_manager' \
 && chmod -R a+rwX .cache
# What else of the repository runs there; a change of it leaves the layer above as it is.
COPY LICENSE CHANGELOG.md /opt/rockslip/
COPY benchmarks /opt/rockslip/benchmarks
COPY demos /opt/rockslip/demos
CMD ["rockslip"]
