// Processor time of this process, and free memory handed back to the system; src/performance/clock.rs is the only caller.

#include <malloc.h>
#include <time.h>

#include <cstdint>

namespace {

uint64_t nanoseconds(clockid_t clock) {
    timespec t;
    clock_gettime(clock, &t);
    return uint64_t(t.tv_sec) * 1000000000u + uint64_t(t.tv_nsec);
}

}  // namespace

extern "C" {

// Nanoseconds that all threads of this process have run.
uint64_t peer_processor_ns() { return nanoseconds(CLOCK_PROCESS_CPUTIME_ID); }

// Pages that hold no allocation go back to the system, so that who allocates next pays for fresh ones.
void peer_release_free_memory() { malloc_trim(0); }

// Bytes in allocations.
uint64_t peer_allocated_bytes() {
    struct mallinfo2 m = mallinfo2();
    return uint64_t(m.uordblks) + uint64_t(m.hblkhd);
}

}  // extern "C"
