// A C interface to the parts of OpenSubdiv that the comparison needs. Every function that fills arrays takes ones of
// the size that peer_level_counts gives; src/opensubdiv.rs is the only caller.

#include <opensubdiv/bfr/refinerSurfaceFactory.h>
#include <opensubdiv/bfr/surface.h>
#include <opensubdiv/far/error.h>
#include <opensubdiv/far/primvarRefiner.h>
#include <opensubdiv/far/ptexIndices.h>
#include <opensubdiv/far/topologyDescriptor.h>
#include <opensubdiv/version.h>

#include <cmath>
#include <cstdint>
#include <cstring>
#include <memory>
#include <string>
#include <vector>

using namespace OpenSubdiv;
using Factory = Far::TopologyRefinerFactory<Far::TopologyDescriptor>;

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
    int scheme;        // 0 bilinear, 1 Catmull-Clark, 2 Loop
    int boundary;      // 0 none, 1 edge only, 2 edge and corner
    int creasing;      // 0 uniform, 1 Chaikin
    int triangles;     // 0 Catmull-Clark, 1 smooth
    int face_varying;  // 0 none, 1 corners only, 2 corners plus 1, 3 corners plus 2, 4 boundaries, 5 all
};

struct PeerRefiner {
    std::unique_ptr<Far::TopologyRefiner> refiner;
};

namespace {

thread_local std::string messages;

void onError(Far::ErrorType, char const* message) { messages += message; }
void onWarning(char const* message) { messages += message; }

template <class Real>
struct Point {
    Real v[3];
    void Clear(void* = nullptr) { v[0] = v[1] = v[2] = 0; }
    void AddWithWeight(Point const& p, Real w) {
        for (int k = 0; k < 3; ++k) v[k] += w * p.v[k];
    }
};

template <class Real>
void positions(PeerRefiner const* r, Real* points) {
    Far::PrimvarRefinerReal<Real> primvar(*r->refiner);
    Point<Real>* from = reinterpret_cast<Point<Real>*>(points);
    for (int level = 1; level <= r->refiner->GetMaxLevel(); ++level) {
        Point<Real>* to = from + r->refiner->GetLevel(level - 1).GetNumVertices();
        primvar.Interpolate(level, from, to);
        from = to;
    }
}

}  // namespace

extern "C" {

int peer_version() { return OPENSUBDIV_VERSION_NUMBER; }

// The text of what went wrong is copied into `error` (always terminated).
PeerRefiner* peer_refine(PeerShape const* s, int levels, int faces_first, char* error, int error_size) {
    messages.clear();
    Far::SetErrorCallback(onError);
    Far::SetWarningCallback(onWarning);
    Far::TopologyDescriptor d;
    d.numVertices = s->vertex_count;
    d.numFaces = s->face_count;
    d.numVertsPerFace = s->counts;
    d.vertIndicesPerFace = s->indices;
    d.numCreases = s->crease_count;
    d.creaseVertexIndexPairs = s->crease_vertices;
    d.creaseWeights = s->crease_sharpness;
    d.numCorners = s->corner_count;
    d.cornerVertexIndices = s->corner_vertices;
    d.cornerWeights = s->corner_sharpness;
    d.numHoles = s->hole_count;
    d.holeIndices = s->holes;
    Sdc::Options o;
    o.SetVtxBoundaryInterpolation(Sdc::Options::VtxBoundaryInterpolation(s->boundary));
    o.SetCreasingMethod(Sdc::Options::CreasingMethod(s->creasing));
    o.SetTriangleSubdivision(Sdc::Options::TriangleSubdivision(s->triangles));
    o.SetFVarLinearInterpolation(Sdc::Options::FVarLinearInterpolation(s->face_varying));
    Factory::Options options(Sdc::SchemeType(s->scheme), o);
    std::unique_ptr<Far::TopologyRefiner> refiner(Factory::Create(d, options));
    if (refiner) {
        Far::TopologyRefiner::UniformOptions uniform(levels);
        uniform.fullTopologyInLastLevel = true;
        uniform.orderVerticesFromFacesFirst = faces_first != 0;
        refiner->RefineUniform(uniform);
    }
    std::strncpy(error, messages.c_str(), error_size);
    error[error_size - 1] = 0;
    return refiner ? new PeerRefiner{std::move(refiner)} : nullptr;
}

void peer_free(PeerRefiner* r) { delete r; }

// Vertices, edges, faces, face corners.
void peer_level_counts(PeerRefiner const* r, int level, int counts[4]) {
    Far::TopologyLevel const& l = r->refiner->GetLevel(level);
    counts[0] = l.GetNumVertices();
    counts[1] = l.GetNumEdges();
    counts[2] = l.GetNumFaces();
    counts[3] = l.GetNumFaceVertices();
}

void peer_level_faces(PeerRefiner const* r, int level, int* counts, int* vertices, int* edges, uint8_t* holes) {
    Far::TopologyLevel const& l = r->refiner->GetLevel(level);
    for (int f = 0; f < l.GetNumFaces(); ++f) {
        Far::ConstIndexArray v = l.GetFaceVertices(f), e = l.GetFaceEdges(f);
        counts[f] = v.size();
        for (int i = 0; i < v.size(); ++i) *vertices++ = v[i], *edges++ = e[i];
        holes[f] = l.IsFaceHole(f);
    }
}

void peer_level_edges(PeerRefiner const* r, int level, int* vertices, float* sharpness, uint8_t* non_manifold,
                      int* face_counts) {
    Far::TopologyLevel const& l = r->refiner->GetLevel(level);
    for (int e = 0; e < l.GetNumEdges(); ++e) {
        Far::ConstIndexArray v = l.GetEdgeVertices(e);
        vertices[2 * e] = v[0];
        vertices[2 * e + 1] = v[1];
        sharpness[e] = l.GetEdgeSharpness(e);
        non_manifold[e] = l.IsEdgeNonManifold(e);
        face_counts[e] = l.GetEdgeFaces(e).size();
    }
}

void peer_level_vertices(PeerRefiner const* r, int level, float* sharpness, uint8_t* non_manifold, uint8_t* rules) {
    Far::TopologyLevel const& l = r->refiner->GetLevel(level);
    for (int v = 0; v < l.GetNumVertices(); ++v) {
        sharpness[v] = l.GetVertexSharpness(v);
        non_manifold[v] = l.IsVertexNonManifold(v);
        rules[v] = uint8_t(l.GetVertexRule(v));
    }
}

// For every vertex of `level` > 0, the kind of its parent (0 vertex, 1 edge, 2 face) and its index.
void peer_level_origins(PeerRefiner const* r, int level, uint8_t* kinds, int* parents) {
    Far::TopologyLevel const& l = r->refiner->GetLevel(level - 1);
    auto set = [&](int child, int kind, int parent) {
        if (child >= 0) kinds[child] = uint8_t(kind), parents[child] = parent;
    };
    for (int v = 0; v < l.GetNumVertices(); ++v) set(l.GetVertexChildVertex(v), 0, v);
    for (int e = 0; e < l.GetNumEdges(); ++e) set(l.GetEdgeChildVertex(e), 1, e);
    if (r->refiner->GetSchemeType() == Sdc::SCHEME_LOOP) return;  // no face points, and no array to ask
    for (int f = 0; f < l.GetNumFaces(); ++f) set(l.GetFaceChildVertex(f), 2, f);
}

// `points` holds those of all levels one after the other; level 0 is given, the others are computed.
void peer_positions_f64(PeerRefiner const* r, double* points) { positions(r, points); }
void peer_positions_f32(PeerRefiner const* r, float* points) { positions(r, points); }

// Limit of the points of the finest level, with two tangents.
void peer_limit(PeerRefiner const* r, double const* points, double* position, double* tangent1, double* tangent2) {
    using P = Point<double>;
    Far::PrimvarRefinerReal<double> primvar(*r->refiner);
    P const* from = reinterpret_cast<P const*>(points);
    P *p = reinterpret_cast<P*>(position), *t1 = reinterpret_cast<P*>(tangent1), *t2 = reinterpret_cast<P*>(tangent2);
    primvar.Limit(from, p, t1, t2);
}

// Position and first derivatives at (u, v) of ptex faces: `jets` gets nine numbers a sample, NaN on holes. Derivatives
// are with respect to the ptex face's own unit square.
void peer_eval(PeerRefiner const* r, double const* points, int samples, int const* ptex_faces, double const* uv,
               int approx_smooth, int approx_sharp, double* jets) {
    Far::TopologyRefiner const& refiner = *r->refiner;
    Bfr::SurfaceFactory::Options options;
    options.SetApproxLevelSmooth(approx_smooth).SetApproxLevelSharp(approx_sharp);
    Bfr::RefinerSurfaceFactory<> factory(refiner, options);
    Far::PtexIndices ptex(refiner);
    int faces = refiner.GetLevel(0).GetNumFaces();
    std::vector<int> face_of(ptex.GetNumFaces());
    for (int f = 0; f < faces; ++f) {
        int end = f + 1 < faces ? ptex.GetFaceId(f + 1) : ptex.GetNumFaces();
        for (int p = ptex.GetFaceId(f); p < end; ++p) face_of[p] = f;
    }
    Bfr::Surface<double>::PointDescriptor three(3);
    Bfr::Surface<double> surface;
    std::vector<double> patch;
    int current = -1;
    bool valid = false;
    for (int i = 0; i < samples; ++i) {
        double* jet = jets + 9 * i;
        for (int k = 0; k < 9; ++k) jet[k] = NAN;
        if (ptex_faces[i] < 0 || ptex_faces[i] >= int(face_of.size())) continue;
        int face = face_of[ptex_faces[i]];
        if (face != current) {
            current = face;
            valid = factory.InitVertexSurface(face, &surface);
            if (valid) {
                patch.assign(3 * size_t(surface.GetNumPatchPoints()), 0);
                surface.PreparePatchPoints(points, three, patch.data(), three);
            }
        }
        if (!valid) continue;
        double local[2] = {uv[2 * i], uv[2 * i + 1]}, at[2] = {local[0], local[1]}, scale = 1;
        Bfr::Parameterization domain = surface.GetParameterization();
        if (domain.HasSubFaces()) {
            domain.ConvertNormalizedSubFaceToCoord(ptex_faces[i] - ptex.GetFaceId(face), local, at);
            scale = 0.5;
        }
        surface.Evaluate(at, patch.data(), three, jet, jet + 3, jet + 6);
        for (int k = 3; k < 9; ++k) jet[k] *= scale;
    }
}

}  // extern "C"
