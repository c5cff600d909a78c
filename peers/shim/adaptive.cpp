// OpenSubdiv's feature-adaptive refinement and Ptex adjacency; src/adaptive.rs is the only caller.

#include "peer.h"

#include <opensubdiv/far/patchTableFactory.h>
#include <opensubdiv/far/ptexIndices.h>
#include <opensubdiv/far/stencilTableFactory.h>
#include <opensubdiv/far/topologyRefiner.h>

#include <algorithm>
#include <cstdint>
#include <memory>
#include <vector>

// A refiner that was refined to level 0 can be refined adaptively here, once.

extern "C" struct PeerPatch {
    int ptex_face, u, v, depth;  // u, v: corner 0 in units of the patch (see Far::PatchParam)
    int regular, sides, non_quad_root;
    float sharpness;  // of a single-crease patch, else 0
};

struct PeerAdaptive {
    std::vector<PeerPatch> patches;
    std::vector<int> vertices;
    // Indices in patches, end caps' own points, weights of stencils from level to level, of end caps, and of stencils
    // over the control points (end caps included).
    int64_t sizes[5];
};

extern "C" {

PeerAdaptive* peer_adaptive(PeerRefiner* r, int isolation, int single_crease) {
    using Factory = Far::PatchTableFactory;
    Factory::Options options(isolation);
    options.useInfSharpPatch = true;
    options.useSingleCreasePatch = single_crease != 0;
    options.generateLegacySharpCornerPatches = false;
    options.generateVaryingTables = false;
    options.SetEndCapType(Factory::Options::ENDCAP_GREGORY_BASIS);
    Far::TopologyRefiner& refiner = *r->refiner;
    refiner.RefineAdaptive(options.GetRefineAdaptiveOptions());
    std::unique_ptr<Far::PatchTable const> table(Factory::Create(refiner, options));

    PeerAdaptive* a = new PeerAdaptive();
    for (int level = 0; level <= refiner.GetMaxLevel(); ++level) {
        a->vertices.push_back(refiner.GetLevel(level).GetNumVertices());
    }
    for (int array = 0; array < table->GetNumPatchArrays(); ++array) {
        Far::ConstPatchParamArray params = table->GetPatchParams(array);
        a->sizes[0] += int64_t(table->GetNumPatches(array)) * table->GetPatchArrayDescriptor(array).GetNumControlVertices();
        for (int i = 0; i < params.size(); ++i) {
            Far::PatchParam const& p = params[i];
            float sharpness = single_crease ? table->GetSingleCreasePatchSharpnessValue(array, i) : 0;
            a->patches.push_back({p.GetFaceId(), p.GetU(), p.GetV(), p.GetDepth(), p.IsRegular(), p.GetBoundary(),
                                  p.NonQuadRoot(), sharpness});
        }
    }
    a->sizes[1] = table->GetNumLocalPoints();
    Far::StencilTableFactory::Options stencils;
    stencils.generateIntermediateLevels = true;
    stencils.factorizeIntermediateLevels = false;
    std::unique_ptr<Far::StencilTable const> levels(Far::StencilTableFactory::Create(refiner, stencils));
    a->sizes[2] = levels->GetWeights().size();
    Far::StencilTable const* caps = table->GetLocalPointStencilTable();
    a->sizes[3] = caps ? caps->GetWeights().size() : 0;
    stencils.factorizeIntermediateLevels = true;
    std::unique_ptr<Far::StencilTable const> base(Far::StencilTableFactory::Create(refiner, stencils));
    a->sizes[4] = base->GetWeights().size();
    if (caps) {
        std::unique_ptr<Far::StencilTable const> all(
            Far::StencilTableFactory::AppendLocalPointStencilTable(refiner, base.get(), caps));
        if (all) a->sizes[4] = all->GetWeights().size();
    }
    return a;
}

void peer_adaptive_free(PeerAdaptive* a) { delete a; }

// Patches, levels.
void peer_adaptive_counts(PeerAdaptive const* a, int64_t counts[2], int64_t sizes[5]) {
    counts[0] = a->patches.size();
    counts[1] = a->vertices.size();
    for (int i = 0; i < 5; ++i) sizes[i] = a->sizes[i];
}

void peer_adaptive_fill(PeerAdaptive const* a, PeerPatch* patches, int* vertices) {
    std::copy(a->patches.begin(), a->patches.end(), patches);
    std::copy(a->vertices.begin(), a->vertices.end(), vertices);
}

int peer_ptex_faces(PeerRefiner const* r) { return Far::PtexIndices(*r->refiner).GetNumFaces(); }

// Per base face its first Ptex face; per Ptex face four neighbours (-1: none) and the edges of theirs that meet.
void peer_ptex_adjacency(PeerRefiner const* r, int* first, int* faces, int* edges) {
    Far::PtexIndices ptex(*r->refiner);
    Far::TopologyLevel const& level = r->refiner->GetLevel(0);
    for (int f = 0; f < level.GetNumFaces(); ++f) {
        first[f] = ptex.GetFaceId(f);
        int end = f + 1 < level.GetNumFaces() ? ptex.GetFaceId(f + 1) : ptex.GetNumFaces();
        for (int id = first[f]; id < end; ++id) {
            ptex.GetAdjacency(*r->refiner, f, id - first[f], faces + 4 * id, edges + 4 * id);
        }
    }
}

}  // extern "C"
