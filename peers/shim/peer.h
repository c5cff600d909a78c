// What the files of the shim share: the shape as it comes from Rust, the refiner, and points to interpolate.

#pragma once

#include <opensubdiv/far/error.h>
#include <opensubdiv/far/primvarRefiner.h>
#include <opensubdiv/far/ptexIndices.h>
#include <opensubdiv/far/topologyDescriptor.h>

#include <cstdint>
#include <memory>
#include <vector>

using namespace OpenSubdiv;

extern "C" struct PeerShape {
    int vertex_count, face_count;
    const int *counts, *indices;
    int crease_count;
    const int* crease_vertices;  // pairs
    const float* crease_sharpness;
    int corner_count;
    const int* corner_vertices;
    const float* corner_sharpness;
    int hole_count;
    const int* holes;
    int value_count;         // of the face-varying channel; 0: there is none
    const int* value_indices;  // one per face corner
    int scheme;        // 0 bilinear, 1 Catmull-Clark, 2 Loop
    int boundary;      // 0 none, 1 edge only, 2 edge and corner
    int creasing;      // 0 uniform, 1 Chaikin
    int triangles;     // 0 Catmull-Clark, 1 smooth
    int face_varying;  // 0 none, 1 corners only, 2 corners plus 1, 3 corners plus 2, 4 boundaries, 5 all
};

struct PeerRefiner {
    std::unique_ptr<Far::TopologyRefiner> refiner;
};

template <class Real, int N>
struct Row {
    Real v[N];
    void Clear(void* = nullptr) {
        for (int k = 0; k < N; ++k) v[k] = 0;
    }
    void AddWithWeight(Row const& p, Real w) {
        for (int k = 0; k < N; ++k) v[k] += w * p.v[k];
    }
};
template <class Real>
using Point = Row<Real, 3>;

// The refiner before any refinement, or null; what went wrong is copied into `error` (always terminated).
std::unique_ptr<Far::TopologyRefiner> createRefiner(PeerShape const& s, char* error, int error_size);

// `points` holds those of all levels one after the other; level 0 is given, the others are computed.
template <class Real>
void interpolateLevels(Far::TopologyRefiner const& refiner, Real* points) {
    Far::PrimvarRefinerReal<Real> primvar(refiner);
    Point<Real>* from = reinterpret_cast<Point<Real>*>(points);
    for (int level = 1; level <= refiner.GetMaxLevel(); ++level) {
        Point<Real>* to = from + refiner.GetLevel(level - 1).GetNumVertices();
        primvar.Interpolate(level, from, to);
        from = to;
    }
}
