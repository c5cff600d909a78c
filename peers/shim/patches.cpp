// Feature-adaptive patch tables as they are used for speed: single precision, Gregory end caps, infinitely sharp
// patches, no varying tables. src/performance/rivals/patches.rs is the only caller.

#include "peer.h"

#include <opensubdiv/far/patchMap.h>
#include <opensubdiv/far/patchTableFactory.h>
#include <opensubdiv/far/stencilTableFactory.h>
#include <opensubdiv/osd/cpuEvaluator.h>
#include <opensubdiv/osd/cpuPatchTable.h>

#include <memory>
#include <vector>

extern "C" struct PeerPlace {
    int ptex_face;
    float u, v;
};

struct PeerPatches {
    std::unique_ptr<Far::TopologyRefiner> refiner;
    std::unique_ptr<Far::PatchTable const> table;
    std::unique_ptr<Far::PatchMap const> map;
    // Only where the batch evaluator is used.
    std::unique_ptr<Osd::CpuPatchTable const> flat;
    std::vector<Osd::PatchCoord> places;
};

struct PeerLimitStencils {
    std::unique_ptr<Far::LimitStencilTable const> table;
};

namespace {

float* row(float* values, size_t i) { return values ? values + 3 * i : nullptr; }

}  // namespace

extern "C" {

// Refiner, patch table and patch map; no points yet. Levels at sharp features, and where nothing is sharp.
PeerPatches* peer_patches(PeerShape const* s, int isolation, int smooth_isolation, int single_crease, char* error,
                          int error_size) {
    std::unique_ptr<PeerPatches> p(new PeerPatches);
    p->refiner = createRefiner(*s, error, error_size);
    if (!p->refiner) return nullptr;
    Far::PatchTableFactory::Options options(isolation);
    options.SetPatchPrecision<float>();
    options.SetEndCapType(Far::PatchTableFactory::Options::ENDCAP_GREGORY_BASIS);
    options.useInfSharpPatch = true;
    options.useSingleCreasePatch = single_crease != 0;
    options.generateLegacySharpCornerPatches = false;
    options.generateVaryingTables = false;
    Far::TopologyRefiner::AdaptiveOptions adaptive = options.GetRefineAdaptiveOptions();
    adaptive.SetSecondaryLevel(smooth_isolation);
    p->refiner->RefineAdaptive(adaptive);
    p->table.reset(Far::PatchTableFactory::Create(*p->refiner, options));
    p->map.reset(new Far::PatchMap(*p->table));
    return p.release();
}

void peer_patches_free(PeerPatches* p) { delete p; }

// Points (control, refined, local) and patches.
void peer_patches_counts(PeerPatches const* p, int counts[2]) {
    counts[0] = p->refiner->GetNumVerticesTotal() + p->table->GetNumLocalPoints();
    counts[1] = p->table->GetNumPatchesTotal();
}

// `points` has room for all; control points are given.
void peer_patches_points(PeerPatches const* p, float* points) {
    interpolateLevels(*p->refiner, points);
    if (p->table->GetNumLocalPoints() > 0) {
        using P = Point<float>;
        P* all = reinterpret_cast<P*>(points);
        p->table->GetLocalPointStencilTable<float>()->UpdateValues(all, all + p->refiner->GetNumVerticesTotal());
    }
}

// Position and first derivatives at every place, each found in the map first; derivatives may be null.
void peer_patches_eval(PeerPatches const* p, float const* points, PeerPlace const* places, int count, float* position,
                       float* du, float* dv) {
    for (int i = 0; i < count; ++i) {
        PeerPlace const& at = places[i];
        Far::PatchTable::PatchHandle const* handle = p->map->FindPatch(at.ptex_face, at.u, at.v);
        float weights[3][20];
        Far::ConstIndexArray control;
        if (handle) {
            control = p->table->GetPatchVertices(*handle);
            p->table->EvaluateBasis(*handle, at.u, at.v, weights[0], du ? weights[1] : nullptr,
                                    dv ? weights[2] : nullptr);
        }
        float* out[3] = {row(position, i), row(du, i), row(dv, i)};
        for (int k = 0; k < 3; ++k) {
            if (!out[k]) continue;
            float x = 0, y = 0, z = 0;
            for (int j = 0; j < control.size(); ++j) {
                float const* from = points + 3 * size_t(control[j]);
                x += weights[k][j] * from[0], y += weights[k][j] * from[1], z += weights[k][j] * from[2];
            }
            out[k][0] = x, out[k][1] = y, out[k][2] = z;
        }
    }
}

// Looks places up once, for the batch evaluator. How many lie on patches.
int peer_patches_locate(PeerPatches* p, PeerPlace const* places, int count) {
    p->flat.reset(new Osd::CpuPatchTable(p->table.get()));
    p->places.clear();
    for (int i = 0; i < count; ++i) {
        Far::PatchTable::PatchHandle const* handle = p->map->FindPatch(places[i].ptex_face, places[i].u, places[i].v);
        if (handle) p->places.emplace_back(*handle, places[i].u, places[i].v);
    }
    return int(p->places.size());
}

// Osd's batch evaluator at the places looked up; derivatives may be null.
void peer_patches_eval_batch(PeerPatches const* p, float const* points, float* position, float* du, float* dv) {
    Osd::BufferDescriptor const three(0, 3, 3);
    int const count = int(p->places.size());
    Osd::PatchArray const* arrays = p->flat->GetPatchArrayBuffer();
    int const* indices = p->flat->GetPatchIndexBuffer();
    Osd::PatchParam const* params = p->flat->GetPatchParamBuffer();
    if (du) {
        Osd::CpuEvaluator::EvalPatches(points, three, position, three, du, three, dv, three, count, p->places.data(),
                                       arrays, indices, params);
    } else {
        Osd::CpuEvaluator::EvalPatches(points, three, position, three, count, p->places.data(), arrays, indices,
                                       params);
    }
}

// Limit stencils of position and first derivatives, from the refiner and the patch table that are at hand. Places in a
// row on one face make one array of locations.
PeerLimitStencils* peer_limit_stencils(PeerPatches const* p, PeerPlace const* places, int count) {
    std::vector<float> u, v;
    for (int i = 0; i < count; ++i) u.push_back(places[i].u), v.push_back(places[i].v);
    Far::LimitStencilTableFactory::LocationArrayVec locations;
    for (int i = 0; i < count; ++i) {
        if (locations.empty() || locations.back().ptexIdx != places[i].ptex_face) {
            locations.emplace_back();
            locations.back().ptexIdx = places[i].ptex_face;
            locations.back().s = &u[size_t(i)], locations.back().t = &v[size_t(i)];
        }
        ++locations.back().numLocations;
    }
    return new PeerLimitStencils{std::unique_ptr<Far::LimitStencilTable const>(
        Far::LimitStencilTableFactory::Create(*p->refiner, locations, nullptr, p->table.get()))};
}

void peer_limit_stencils_free(PeerLimitStencils* s) { delete s; }

int peer_limit_stencils_count(PeerLimitStencils const* s) { return s->table ? s->table->GetNumStencils() : 0; }

void peer_limit_stencils_apply(PeerLimitStencils const* s, float const* control, float* position, float* du,
                               float* dv) {
    Far::LimitStencilTable const& t = *s->table;
    Osd::BufferDescriptor const three(0, 3, 3);
    Osd::CpuEvaluator::EvalStencils(control, three, position, three, du, three, dv, three, t.GetSizes().data(),
                                    t.GetOffsets().data(), t.GetControlIndices().data(), t.GetWeights().data(),
                                    t.GetDuWeights().data(), t.GetDvWeights().data(), 0, t.GetNumStencils());
}

}  // extern "C"
