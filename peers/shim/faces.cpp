// Bfr as it is used for speed: single precision, one surface a face, with or without the cache of irregular
// topology. src/performance/rivals/faces.rs is the only caller.

#include "peer.h"

#include <opensubdiv/bfr/refinerSurfaceFactory.h>
#include <opensubdiv/bfr/surface.h>

#include <memory>
#include <vector>

using Surface = Bfr::Surface<float>;

struct PeerFaces {
    std::unique_ptr<Far::TopologyRefiner> refiner;
    std::vector<Surface> surfaces;
    std::vector<size_t> offset;  // of a face's patch points, in floats
    std::vector<float> patch_points;
};

extern "C" {

// The mesh with surfaces that are not initialised yet.
PeerFaces* peer_faces(PeerShape const* s, char* error, int error_size) {
    std::unique_ptr<PeerFaces> p(new PeerFaces);
    p->refiner = createRefiner(*s, error, error_size);
    if (!p->refiner) return nullptr;
    p->surfaces.resize(size_t(s->face_count));
    return p.release();
}

void peer_faces_free(PeerFaces* p) { delete p; }

// Initialises the surface of every face, from a factory that is new; approximation levels as Bfr's own defaults (2 at
// smooth features, 6 at sharp ones).
void peer_faces_init(PeerFaces* p, int cached) {
    Bfr::SurfaceFactory::Options options;
    options.EnableCaching(cached != 0);
    Bfr::RefinerSurfaceFactory<> factory(*p->refiner, options);
    for (size_t f = 0; f < p->surfaces.size(); ++f) factory.InitVertexSurface(int(f), &p->surfaces[f]);
}

// Computes the patch points of all faces: once per frame.
void peer_faces_prepare(PeerFaces* p, float const* control) {
    Surface::PointDescriptor const three(3);
    if (p->offset.empty()) {
        p->offset.push_back(0);
        for (Surface const& s : p->surfaces) {
            p->offset.push_back(p->offset.back() + (s.IsValid() ? 3 * size_t(s.GetNumPatchPoints()) : 0));
        }
        p->patch_points.resize(p->offset.back());
    }
    for (size_t f = 0; f < p->surfaces.size(); ++f) {
        if (p->surfaces[f].IsValid()) {
            p->surfaces[f].PreparePatchPoints(control, three, &p->patch_points[p->offset[f]], three);
        }
    }
}

// Position and first derivatives: `uv` in the parameters of the face's own domain.
void peer_faces_eval(PeerFaces const* p, int const* faces, float const* uv, int count, float* position, float* du,
                     float* dv) {
    Surface::PointDescriptor const three(3);
    for (int i = 0; i < count; ++i) {
        Surface const& s = p->surfaces[size_t(faces[i])];
        if (!s.IsValid()) continue;
        float const* points = &p->patch_points[p->offset[size_t(faces[i])]];
        s.Evaluate(uv + 2 * size_t(i), points, three, position + 3 * size_t(i), du + 3 * size_t(i),
                   dv + 3 * size_t(i));
    }
}

// (u, v) of a sub-face in the domain of its face.
void peer_faces_parameters(PeerFaces const* p, int face, int subface, float const local[2], float uv[2]) {
    uv[0] = local[0], uv[1] = local[1];
    Surface const& s = p->surfaces[size_t(face)];
    if (s.IsValid() && s.GetParameterization().HasSubFaces()) {
        s.GetParameterization().ConvertNormalizedSubFaceToCoord(subface, local, uv);
    }
}

}  // extern "C"
