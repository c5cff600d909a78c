// A C interface to the parts of OpenSubdiv that the comparison needs: uniform refinement, and limits of its vertices.
// Every function that fills arrays takes ones of the size that peer_level_counts gives; src/opensubdiv.rs is the only
// caller.

#include "peer.h"

#include <opensubdiv/version.h>

#include <cstring>
#include <mutex>
#include <string>

using Factory = Far::TopologyRefinerFactory<Far::TopologyDescriptor>;

namespace {

thread_local std::string messages;

void onError(Far::ErrorType, char const* message) { messages += message; }
void onWarning(char const* message) { messages += message; }

}  // namespace

std::unique_ptr<Far::TopologyRefiner> createRefiner(PeerShape const& s, char* error, int error_size) {
    static std::once_flag once;
    std::call_once(once, [] {
        Far::SetErrorCallback(onError);
        Far::SetWarningCallback(onWarning);
    });
    messages.clear();
    Far::TopologyDescriptor d;
    d.numVertices = s.vertex_count;
    d.numFaces = s.face_count;
    d.numVertsPerFace = s.counts;
    d.vertIndicesPerFace = s.indices;
    d.numCreases = s.crease_count;
    d.creaseVertexIndexPairs = s.crease_vertices;
    d.creaseWeights = s.crease_sharpness;
    d.numCorners = s.corner_count;
    d.cornerVertexIndices = s.corner_vertices;
    d.cornerWeights = s.corner_sharpness;
    d.numHoles = s.hole_count;
    d.holeIndices = s.holes;
    Far::TopologyDescriptor::FVarChannel channel;
    channel.numValues = s.value_count;
    channel.valueIndices = s.value_indices;
    if (s.value_count > 0) {
        d.numFVarChannels = 1;
        d.fvarChannels = &channel;
    }
    Sdc::Options o;
    o.SetVtxBoundaryInterpolation(Sdc::Options::VtxBoundaryInterpolation(s.boundary));
    o.SetCreasingMethod(Sdc::Options::CreasingMethod(s.creasing));
    o.SetTriangleSubdivision(Sdc::Options::TriangleSubdivision(s.triangles));
    o.SetFVarLinearInterpolation(Sdc::Options::FVarLinearInterpolation(s.face_varying));
    Factory::Options options(Sdc::SchemeType(s.scheme), o);
    std::unique_ptr<Far::TopologyRefiner> refiner(Factory::Create(d, options));
    std::strncpy(error, messages.c_str(), error_size);
    error[error_size - 1] = 0;
    return refiner;
}

extern "C" {

int peer_version() { return OPENSUBDIV_VERSION_NUMBER; }

// What went wrong is copied into `error`.
PeerRefiner* peer_refine(PeerShape const* s, int levels, int faces_first, char* error, int error_size) {
    std::unique_ptr<Far::TopologyRefiner> refiner = createRefiner(*s, error, error_size);
    if (!refiner) return nullptr;
    Far::TopologyRefiner::UniformOptions uniform(levels);
    uniform.fullTopologyInLastLevel = true;
    uniform.orderVerticesFromFacesFirst = faces_first != 0;
    refiner->RefineUniform(uniform);
    return new PeerRefiner{std::move(refiner)};
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
void peer_positions_f64(PeerRefiner const* r, double* points) { interpolateLevels(*r->refiner, points); }
void peer_positions_f32(PeerRefiner const* r, float* points) { interpolateLevels(*r->refiner, points); }

// Limit of the points of the finest level, with two tangents.
void peer_limit(PeerRefiner const* r, double const* points, double* position, double* tangent1, double* tangent2) {
    using P = Point<double>;
    Far::PrimvarRefinerReal<double> primvar(*r->refiner);
    P const* from = reinterpret_cast<P const*>(points);
    P *p = reinterpret_cast<P*>(position), *t1 = reinterpret_cast<P*>(tangent1), *t2 = reinterpret_cast<P*>(tangent2);
    primvar.Limit(from, p, t1, t2);
}

}  // extern "C"
