// Face-varying values: one channel of pairs of numbers per shape. Indices at face corners are in the order of
// peer_level_faces.

#include "peer.h"

extern "C" {

// Number of values of a level.
int peer_value_count(PeerRefiner const* r, int level) { return r->refiner->GetLevel(level).GetNumFVarValues(0); }

// The value's index at every face corner of a level.
void peer_value_indices(PeerRefiner const* r, int level, int* indices) {
    Far::TopologyLevel const& l = r->refiner->GetLevel(level);
    for (int f = 0; f < l.GetNumFaces(); ++f) {
        Far::ConstIndexArray values = l.GetFaceFVarValues(f, 0);
        for (int i = 0; i < values.size(); ++i) *indices++ = values[i];
    }
}

// `values` holds those of all levels one after the other; level 0 is given, the others are computed.
void peer_values(PeerRefiner const* r, double* values) {
    Far::PrimvarRefinerReal<double> primvar(*r->refiner);
    Row<double, 2>* from = reinterpret_cast<Row<double, 2>*>(values);
    for (int level = 1; level <= r->refiner->GetMaxLevel(); ++level) {
        Row<double, 2>* to = from + r->refiner->GetLevel(level - 1).GetNumFVarValues(0);
        primvar.InterpolateFaceVarying(level, from, to, 0);
        from = to;
    }
}

// Limits of the values of the finest level.
void peer_value_limits(PeerRefiner const* r, double const* values, double* limits) {
    Far::PrimvarRefinerReal<double> primvar(*r->refiner);
    Row<double, 2> const* from = reinterpret_cast<Row<double, 2> const*>(values);
    Row<double, 2>* to = reinterpret_cast<Row<double, 2>*>(limits);
    primvar.LimitFaceVarying(from, to, 0);
}

}  // extern "C"
