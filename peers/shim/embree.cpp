// Embree's subdivision geometry, version 3 or 4; built where its header is found. src/performance/rivals/embree.rs is
// the only caller.

#include "peer.h"

#if EMBREE_MAJOR == 3
#include <embree3/rtcore.h>
#else
#include <embree4/rtcore.h>
#endif

#include <algorithm>
#include <cmath>
#include <cstring>
#include <vector>

struct PeerEmbree {
    RTCDevice device = nullptr;
    RTCScene scene = nullptr;
    RTCGeometry geometry = nullptr;
    std::vector<float> points, crease_sharpness, corner_sharpness;
    ~PeerEmbree() {
        if (geometry) rtcReleaseGeometry(geometry);
        if (scene) rtcReleaseScene(scene);
        if (device) rtcReleaseDevice(device);
    }
};

namespace {

std::vector<float> sharpness(float const* values, int count) {
    std::vector<float> all(values, values + count);
    for (float& s : all) {
        if (s >= 10) s = INFINITY;
    }
    return all;
}

template <class T>
void share(RTCGeometry geometry, RTCBufferType type, RTCFormat format, T const* data, size_t stride, size_t count) {
    if (count > 0) rtcSetSharedGeometryBuffer(geometry, type, 0, format, data, 0, stride, count);
}

}  // namespace

extern "C" {

int peer_embree_version() { return RTC_VERSION; }

// A committed scene on one thread, ready to be evaluated. The shape's lists must outlive it. Null where Embree fails.
PeerEmbree* peer_embree(PeerShape const* s, float const* points) {
    std::unique_ptr<PeerEmbree> e(new PeerEmbree);
    e->device = rtcNewDevice("threads=1");
    if (!e->device) return nullptr;
    e->scene = rtcNewScene(e->device);
    e->geometry = rtcNewGeometry(e->device, RTC_GEOMETRY_TYPE_SUBDIVISION);
    e->points.assign(points, points + 3 * size_t(s->vertex_count));
    e->points.push_back(0);  // the last point is read sixteen bytes wide
    e->crease_sharpness = sharpness(s->crease_sharpness, s->crease_count);
    e->corner_sharpness = sharpness(s->corner_sharpness, s->corner_count);
    size_t corners = 0;
    for (int f = 0; f < s->face_count; ++f) corners += size_t(s->counts[f]);
    RTCGeometry g = e->geometry;
    share(g, RTC_BUFFER_TYPE_VERTEX, RTC_FORMAT_FLOAT3, e->points.data(), 12, size_t(s->vertex_count));
    share(g, RTC_BUFFER_TYPE_FACE, RTC_FORMAT_UINT, s->counts, 4, size_t(s->face_count));
    share(g, RTC_BUFFER_TYPE_INDEX, RTC_FORMAT_UINT, s->indices, 4, corners);
    share(g, RTC_BUFFER_TYPE_EDGE_CREASE_INDEX, RTC_FORMAT_UINT2, s->crease_vertices, 8, size_t(s->crease_count));
    share(g, RTC_BUFFER_TYPE_EDGE_CREASE_WEIGHT, RTC_FORMAT_FLOAT, e->crease_sharpness.data(), 4,
          size_t(s->crease_count));
    share(g, RTC_BUFFER_TYPE_VERTEX_CREASE_INDEX, RTC_FORMAT_UINT, s->corner_vertices, 4, size_t(s->corner_count));
    share(g, RTC_BUFFER_TYPE_VERTEX_CREASE_WEIGHT, RTC_FORMAT_FLOAT, e->corner_sharpness.data(), 4,
          size_t(s->corner_count));
    RTCSubdivisionMode mode = s->boundary == 2 ? RTC_SUBDIVISION_MODE_PIN_CORNERS : RTC_SUBDIVISION_MODE_SMOOTH_BOUNDARY;
    rtcSetGeometrySubdivisionMode(g, 0, mode);
    rtcCommitGeometry(g);
    rtcAttachGeometry(e->scene, g);
    rtcCommitScene(e->scene);
    return rtcGetDeviceError(e->device) == RTC_ERROR_NONE ? e.release() : nullptr;
}

void peer_embree_free(PeerEmbree* e) { delete e; }

// Position and first derivatives, one place at a time.
void peer_embree_eval(PeerEmbree const* e, unsigned const* faces, float const* u, float const* v, int count,
                      float* position, float* du, float* dv) {
    for (int i = 0; i < count; ++i) {
        alignas(16) float p[4], pu[4], pv[4];
        rtcInterpolate1(e->geometry, faces[i], u[i], v[i], RTC_BUFFER_TYPE_VERTEX, 0, p, pu, pv, 3);
        std::memcpy(position + 3 * size_t(i), p, 12);
        std::memcpy(du + 3 * size_t(i), pu, 12);
        std::memcpy(dv + 3 * size_t(i), pv, 12);
    }
}

// The same through the call that takes many places; results are one coordinate after the other.
void peer_embree_eval_many(PeerEmbree const* e, unsigned const* faces, float const* u, float const* v, int count,
                           float* results) {
    constexpr int kTogether = 1024;
    for (int i = 0; i < count; i += kTogether) {
        RTCInterpolateNArguments a{};
        a.geometry = e->geometry;
        a.N = unsigned(std::min(kTogether, count - i));
        a.primIDs = faces + i, a.u = u + i, a.v = v + i;
        a.bufferType = RTC_BUFFER_TYPE_VERTEX;
        float* at = results + 9 * size_t(i);
        a.P = at, a.dPdu = at + 3 * a.N, a.dPdv = at + 6 * a.N;
        a.valueCount = 3;
        rtcInterpolateN(&a);
    }
}

}  // extern "C"
