// Shapes of rigid bodies: convex polygons, convex polyhedra, and the half-space below a level.
#pragma once

#include <stdexcept>
#include <vector>

#include "linear.hpp"

namespace rockslip {

/// A face with its outward normal n: the points x with n.x = offset, in the frame of the body.
template <int d> struct Face {
    Vec<d> normal;
    double offset;
    Mat<d - 1, d> tangent;
    double area;               // m2; in the plane the length, m
    std::vector<int> corners;  // vertices, anticlockwise seen from outside
    std::vector<int> edges;    // in space; edge k leads from corner k to corner k + 1
    bool inner = false;        // covered by another part of its body: nothing touches it
};

/// An edge of a polyhedron, with the two faces that it joins.
struct Edge {
    int from, to;
    int left, right;
    bool inner = false;  // in or on another part of its body: none of its surface
};

/// A convex shape; without vertices it is the half-space below its only face.
template <int d> struct Shape {
    std::vector<Vec<d>> vertices;
    std::vector<Face<d>> faces;
    std::vector<Edge> edges;
    std::vector<char> inner;  // of each vertex: none of the union of the parts of its body; empty where there is one part
    double radius = 0;  // of the sphere about the origin that holds all vertices, m

    bool is_corner(int vertex) const { return inner.empty() || !inner[vertex]; }
    bool is_surface(std::size_t face) const { return inner.empty() || !faces[face].inner; }
    bool is_half_space() const { return vertices.empty(); }
};

/// Where a body is: x -> R x + centre.
template <int d> struct Placement {
    Vec<d> centre;
    Mat<d, d> R;
};

/// A shape at its place: vertices, normals, and the box around it, in space.
template <int d> struct PlacedShape {
    Placement<d> at;
    std::vector<Vec<d>> vertices, normals;
    Vec<d> low, high;

    void place(const Shape<d>& shape, const Placement<d>& placement) {
        at = placement;
        vertices.resize(shape.vertices.size());
        normals.resize(shape.faces.size());
        low.fill(shape.is_half_space() ? -1e300 : 1e300);
        high.fill(shape.is_half_space() ? 1e300 : -1e300);
        for (std::size_t i = 0; i < vertices.size(); i++) {
            vertices[i] = at.centre + mul(at.R, shape.vertices[i]);
            for (int k = 0; k < d; k++) {
                low[k] = std::min(low[k], vertices[i][k]);
                high[k] = std::max(high[k], vertices[i][k]);
            }
        }
        for (std::size_t i = 0; i < normals.size(); i++) normals[i] = mul(at.R, shape.faces[i].normal);
        if (shape.is_half_space() && normals[0][d - 1] == 1) high[d - 1] = at.centre[d - 1] + shape.faces[0].offset;
    }
};

/// A body at its place: its parts, and the box around all of them.
template <int d> struct PlacedBody {
    Placement<d> at;
    std::vector<PlacedShape<d>> parts;
    Vec<d> low, high;

    void place(const std::vector<Shape<d>>& shapes, const std::vector<int>& numbers, const Placement<d>& placement) {
        at = placement;
        parts.resize(numbers.size());
        for (std::size_t i = 0; i < parts.size(); i++) {
            const PlacedShape<d>& part = parts[i];
            parts[i].place(shapes[numbers[i]], placement);
            if (i == 0) {
                low = part.low;
                high = part.high;
            }
            for (int k = 0; k < d; k++) {
                low[k] = std::min(low[k], part.low[k]);
                high[k] = std::max(high[k], part.high[k]);
            }
        }
    }
};

/// Marks faces, edges and corners of a part of a body that are within another part, or on it: the surface of
/// their union is not there, flat or re-entrant.
template <int d> void mark_inner(Shape<d>& part, const Shape<d>& other, double hair) {
    const auto holds = [&](const Vec<d>& x) {
        return std::all_of(other.faces.begin(), other.faces.end(), [&](const Face<d>& f) { return dot(f.normal, x) - f.offset <= hair; });
    };
    const auto middle = [&](const std::vector<int>& corners) {
        Vec<d> sum{};
        for (int i : corners) sum += part.vertices[i];
        return (1.0 / static_cast<double>(corners.size())) * sum;
    };
    for (Face<d>& face : part.faces) {
        const bool within = std::all_of(face.corners.begin(), face.corners.end(), [&](int i) { return holds(part.vertices[i]); });
        face.inner = face.inner || (within && holds(middle(face.corners) + (10 * hair) * face.normal));
    }
    for (Edge& edge : part.edges) {
        if (!part.faces[edge.left].inner && !part.faces[edge.right].inner) continue;
        // One that goes on in the other part is flat or re-entrant: across it, along the face that is surface.
        const Face<d>& face = part.faces[part.faces[edge.left].inner ? edge.right : edge.left];
        const Vec<d> at = middle({edge.from, edge.to}), way = at - middle(face.corners);
        edge.inner = edge.inner || face.inner || holds(at + (10 * hair / norm(way)) * way);
    }
    part.inner.resize(part.vertices.size(), 0);
    for (const Face<d>& face : part.faces)
        for (std::size_t k = 0; k < face.corners.size(); k++)
            for (int turn : {0, 1}) {  // both ends of a side, on beyond it
                const int to = face.corners[(k + turn) % face.corners.size()], from = face.corners[(k + 1 - turn) % face.corners.size()];
                const Vec<d> way = part.vertices[to] - part.vertices[from];
                if (holds(part.vertices[to] + (10 * hair / norm(way)) * way)) part.inner[to] = 1;
            }
}

/// The half-space below level 0 of its own frame.
template <int d> Shape<d> half_space() {
    Face<d> top{};
    top.normal[d - 1] = 1;
    for (int k = 0; k + 1 < d; k++) top.tangent[k][k] = 1;
    Shape<d> shape;
    shape.faces.push_back(top);
    return shape;
}

/// A convex polygon by its corners, anticlockwise.
inline Shape<2> polygon(const std::vector<Vec<2>>& corners) {
    Shape<2> shape;
    shape.vertices = corners;
    const int count = static_cast<int>(corners.size());
    for (int i = 0; i < count; i++) {
        const int next = (i + 1) % count;
        const Vec<2> side = corners[next] - corners[i];
        const Vec<2> along = (1 / norm(side)) * side, normal{along[1], -along[0]};
        // The tangent is the normal turned clockwise: +x on a top.
        shape.faces.push_back({normal, dot(normal, corners[i]), {-1.0 * along}, norm(side), {i, next}, {}});
        shape.radius = std::max(shape.radius, norm(corners[i]));
    }
    return shape;
}

/// A convex polyhedron by its vertices and the loops around its faces, anticlockwise from outside.
inline Shape<3> polyhedron(const std::vector<Vec<3>>& vertices, const std::vector<std::vector<int>>& loops) {
    Shape<3> shape;
    shape.vertices = vertices;
    for (const Vec<3>& v : vertices) shape.radius = std::max(shape.radius, norm(v));
    for (const std::vector<int>& loop : loops) {
        const int number = static_cast<int>(shape.faces.size()), count = static_cast<int>(loop.size());
        const Vec<3> side = vertices[loop[1]] - vertices[loop[0]];
        const Vec<3> across = cross(side, vertices[loop[2]] - vertices[loop[1]]);
        Face<3> face;
        face.normal = (1 / norm(across)) * across;
        face.tangent[0] = (1 / norm(side)) * side;
        face.tangent[1] = cross(face.normal, face.tangent[0]);
        face.offset = dot(face.normal, vertices[loop[0]]);
        face.area = 0;
        for (int k = 2; k < count; k++)
            face.area += 0.5 * dot(face.normal, cross(vertices[loop[k - 1]] - vertices[loop[0]],
                                                      vertices[loop[k]] - vertices[loop[0]]));
        face.corners = loop;
        for (int k = 0; k < count; k++) {
            const int from = loop[k], to = loop[(k + 1) % count];
            auto same = [&](const Edge& e) { return e.from == to && e.to == from; };
            const auto known = std::find_if(shape.edges.begin(), shape.edges.end(), same);
            face.edges.push_back(static_cast<int>(known - shape.edges.begin()));
            if (known == shape.edges.end()) shape.edges.push_back({from, to, number, -1});
            else known->right = number;
        }
        shape.faces.push_back(face);
    }
    for (const Edge& edge : shape.edges)
        if (edge.right < 0) throw std::invalid_argument("the faces of a polyhedron leave a hole");
    return shape;
}

}  // namespace rockslip
