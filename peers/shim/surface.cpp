// Evaluation of the limit surface by OpenSubdiv: Bfr's surfaces and Far's patch tables.

#include "peer.h"

#include <opensubdiv/bfr/refinerSurfaceFactory.h>
#include <opensubdiv/bfr/surface.h>
#include <opensubdiv/far/patchMap.h>
#include <opensubdiv/far/patchTableFactory.h>

#include <cmath>

namespace {

// Position, two first and three second derivatives.
constexpr int kRows = 6, kJet = 3 * kRows;

void fillWithNan(double* jet) {
    for (int k = 0; k < kJet; ++k) jet[k] = NAN;
}

}  // namespace

extern "C" {

// Position and derivatives at (u, v) of ptex faces: `jets` gets 18 numbers a sample, NaN on holes. Derivatives are with
// respect to the ptex face's own unit square.
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
        double* jet = jets + kJet * i;
        fillWithNan(jet);
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
        surface.Evaluate(at, patch.data(), three, jet, jet + 3, jet + 6, jet + 9, jet + 12, jet + 15);
        for (int k = 3; k < 9; ++k) jet[k] *= scale;
        for (int k = 9; k < kJet; ++k) jet[k] *= scale * scale;
    }
}

// The same from a patch table with features isolated to `level`; `end_cap` as Far::PatchTableFactory::Options numbers
// them (1 bilinear, 2 B-spline, 3 Gregory basis). False if OpenSubdiv refuses the mesh.
bool peer_eval_patches(PeerShape const* s, double const* points, int level, int end_cap, int samples,
                       int const* ptex_faces, double const* uv, double* jets, char* error, int error_size) {
    std::unique_ptr<Far::TopologyRefiner> refiner = createRefiner(*s, error, error_size);
    if (!refiner) return false;
    Far::PatchTableFactory::Options options(level);
    options.SetPatchPrecision<double>();
    options.SetEndCapType(Far::PatchTableFactory::Options::EndCapType(end_cap));
    options.useInfSharpPatch = true;
    options.generateLegacySharpCornerPatches = false;
    refiner->RefineAdaptive(options.GetRefineAdaptiveOptions());
    std::unique_ptr<Far::PatchTable> table(Far::PatchTableFactory::Create(*refiner, options));
    Far::PatchMap map(*table);

    int refined = refiner->GetNumVerticesTotal();
    std::vector<Point<double>> all(size_t(refined + table->GetNumLocalPoints()));
    std::copy(points, points + 3 * size_t(s->vertex_count), &all[0].v[0]);
    interpolateLevels(*refiner, &all[0].v[0]);
    if (table->GetNumLocalPoints() > 0) {
        table->GetLocalPointStencilTable<double>()->UpdateValues(&all[0], &all[refined]);
    }
    for (int i = 0; i < samples; ++i) {
        double* jet = jets + kJet * i;
        fillWithNan(jet);
        double u = uv[2 * i], v = uv[2 * i + 1];
        Far::PatchTable::PatchHandle const* handle = map.FindPatch(ptex_faces[i], u, v);
        if (!handle) continue;
        double weights[kRows][20];
        table->EvaluateBasis(*handle, u, v, weights[0], weights[1], weights[2], weights[3], weights[4], weights[5]);
        Far::ConstIndexArray control = table->GetPatchVertices(*handle);
        for (int row = 0; row < kRows; ++row) {
            Point<double> sum;
            sum.Clear();
            for (int k = 0; k < control.size(); ++k) sum.AddWithWeight(all[control[k]], weights[row][k]);
            // On faces split into sub-faces Far takes (u, v) in the unit square and differentiates by half of them.
            bool half = table->GetPatchParam(*handle).NonQuadRoot() && row > 0;
            double scale = !half ? 1 : row < 3 ? 0.5 : 0.25;
            for (int k = 0; k < 3; ++k) jet[3 * row + k] = scale * sum.v[k];
        }
    }
    return true;
}

}  // extern "C"
