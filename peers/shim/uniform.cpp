// Uniform refinement and stencil tables as they are used for speed: no topology beyond what interpolation
// needs, compact tables. src/performance/rivals/uniform.rs is the only caller.

#include "peer.h"

#include <opensubdiv/far/stencilTableFactory.h>
#include <opensubdiv/osd/cpuEvaluator.h>

#include <algorithm>
#include <memory>

struct PeerStencils {
    std::unique_ptr<Far::StencilTable const> table;
};

namespace {

template <class Real>
void limitPoints(Far::TopologyRefiner const& refiner, Real const* points, Real* position, Real* du, Real* dv) {
    using P = Point<Real>;
    Far::PrimvarRefinerReal<Real> primvar(refiner);
    P const* from = reinterpret_cast<P const*>(points);
    P *p = reinterpret_cast<P*>(position), *u = reinterpret_cast<P*>(du), *v = reinterpret_cast<P*>(dv);
    if (du) {
        primvar.Limit(from, p, u, v);
    } else {
        primvar.Limit(from, p);
    }
}

}  // namespace

extern "C" {

// Control mesh and `levels` refinements; in the last level faces know their vertices, and nothing else unless `full`,
// which limits need.
PeerRefiner* peer_uniform(PeerShape const* s, int levels, int full, char* error, int error_size) {
    std::unique_ptr<Far::TopologyRefiner> refiner = createRefiner(*s, error, error_size);
    if (!refiner) return nullptr;
    Far::TopologyRefiner::UniformOptions options(levels);
    options.fullTopologyInLastLevel = full != 0;
    refiner->RefineUniform(options);
    return new PeerRefiner{std::move(refiner)};
}

// Vertices of all levels, of the last one, and its faces.
void peer_uniform_counts(PeerRefiner const* r, int counts[3]) {
    Far::TopologyLevel const& last = r->refiner->GetLevel(r->refiner->GetMaxLevel());
    counts[0] = r->refiner->GetNumVerticesTotal();
    counts[1] = last.GetNumVertices();
    counts[2] = last.GetNumFaces();
}

// `points` has room for all levels; those of the control mesh are given.
void peer_uniform_points(PeerRefiner const* r, float* points) { interpolateLevels(*r->refiner, points); }
void peer_uniform_points_double(PeerRefiner const* r, double* points) { interpolateLevels(*r->refiner, points); }

// Limit points and tangents of the vertices of the last level; tangents may be null.
void peer_uniform_limit(PeerRefiner const* r, float const* points, float* position, float* du, float* dv) {
    limitPoints(*r->refiner, points, position, du, dv);
}
void peer_uniform_limit_double(PeerRefiner const* r, double const* points, double* position, double* du, double* dv) {
    limitPoints(*r->refiner, points, position, du, dv);
}

// Stencils of the last level's vertices over the control points.
PeerStencils* peer_stencils(PeerRefiner const* r) {
    Far::StencilTableFactory::Options options;
    options.generateIntermediateLevels = false;
    options.generateOffsets = true;
    return new PeerStencils{
        std::unique_ptr<Far::StencilTable const>(Far::StencilTableFactory::Create(*r->refiner, options))};
}

void peer_stencils_free(PeerStencils* s) { delete s; }

int peer_stencils_count(PeerStencils const* s) { return s->table->GetNumStencils(); }

// Rows `start` to `end`, written from the beginning of `out`; `width` floats a point: 3, or 4, for which OpenSubdiv has
// a kernel of its own, which takes a `start` of 0 only.
void peer_stencils_apply(PeerStencils const* s, int width, float const* control, float* out, int start, int end) {
    Far::StencilTable const& t = *s->table;
    Osd::BufferDescriptor const from(0, width, width), to(0, width, width);
    Osd::CpuEvaluator::EvalStencils(control, from, out, to, t.GetSizes().data(), t.GetOffsets().data(),
                                    t.GetControlIndices().data(), t.GetWeights().data(), start, end);
}

}  // extern "C"
