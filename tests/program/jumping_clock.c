// Preloaded into a program: the time of day jumps by days, back and forth, at every look at it.
#define _GNU_SOURCE
#include <dlfcn.h>
#include <sys/time.h>
#include <time.h>

static long jump(void) {
    static volatile long looks;
    const long look = ++looks;
    return (look % 2 ? -1 : 1) * 86400L * (look % 7);
}

int clock_gettime(clockid_t clock, struct timespec* t) {
    int (*real)(clockid_t, struct timespec*) = (int (*)(clockid_t, struct timespec*))dlsym(RTLD_NEXT, "clock_gettime");
    const int result = real(clock, t);
    if (clock == CLOCK_REALTIME) {
        t->tv_sec += jump();
    }
    return result;
}

int gettimeofday(struct timeval* t, void* zone) {
    int (*real)(struct timeval*, void*) = (int (*)(struct timeval*, void*))dlsym(RTLD_NEXT, "gettimeofday");
    const int result = real(t, zone);
    t->tv_sec += jump();
    return result;
}

time_t time(time_t* t) {
    time_t (*real)(time_t*) = (time_t (*)(time_t*))dlsym(RTLD_NEXT, "time");
    const time_t now = real(0) + jump();
    if (t) {
        *t = now;
    }
    return now;
}
