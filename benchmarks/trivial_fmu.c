/* A trivial slave of plain C, for tests and benchmarks of masters:
 *     dx/dt = rate u,   y = x,   z = gain u (at once).
 * It misbehaves on request: from time fail_at on, doStep does what fail_status says
 * (2 discard, 3 error, 4 fatal, 5 crash, 6 never return, 7 NaN, 8 exit, 9 another folder,
 * 10 another rounding, 11 another locale, 12 print, 13 fork, 14 take all memory, 15 give its rate no
 * more, 16 write into descriptors 3 to 255, 17 into every one that is open, 18 write beyond its memory, 19 have faults of
 * arithmetic end the process, 20 drop very small numbers), and a step longer than largest_step is discarded. An FMI 2.0
 * instance whose label is "crash in terminate", "crash in free" or "hang in free" does so, "crash in restore", "hang in
 * restore", "exit in restore" and "discard in restore" when its state is set; one with "no state" gives null for it, and
 * one named "endless" is never instantiated.
 * Compiled with -DFMI3 it speaks FMI 3.0, else FMI 2.0. */
#ifndef _GNU_SOURCE
#define _GNU_SOURCE
#endif
#include <fenv.h>
#include <locale.h>
#include <math.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#ifdef __SSE2__
#include <xmmintrin.h>
#endif
#ifndef _WIN32
#include <unistd.h>
#else
#include <direct.h>
#endif

#ifdef FMI3
#include "fmi3Functions.h"
typedef fmi3Status Status;
typedef fmi3ValueReference Reference;
typedef fmi3Boolean Boolean;
enum { OK = fmi3OK, DISCARD = fmi3Discard, ERROR = fmi3Error };
#else
#include "fmi2Functions.h"
typedef fmi2Status Status;
typedef fmi2ValueReference Reference;
typedef fmi2Boolean Boolean;
enum { OK = fmi2OK, DISCARD = fmi2Discard, ERROR = fmi2Error };
#endif

enum { U, Y, Z, RATE, GAIN, FAIL_AT, LARGEST_STEP, REALS };
enum { FAIL_STATUS = REALS, STEPS, SWITCHED, ON, OFF, LABEL };

typedef struct {
    double r[REALS];
    double slope, curvature;
    int fail_status, steps, switched, on, mute;
    char label[64];
} Data;

typedef struct {
    Data data;
    char name[64];
#ifdef FMI3
    fmi3LogMessageCallback log;
    fmi3IntermediateUpdateCallback update;
    void *environment;
#else
    fmi2CallbackFunctions callbacks;
#endif
} Slave;

static void initial(Data *d) {
    memset(d, 0, sizeof *d);
    d->r[U] = d->r[RATE] = d->r[GAIN] = 1.0;
    d->r[FAIL_AT] = d->r[LARGEST_STEP] = 1e300;
    strcpy(d->label, "none");
}

static void complain(Slave *s, int status, const char *text, double value) {
#ifdef FMI3
    char line[200];
    snprintf(line, sizeof line, "%s %g", text, value);
    s->log(s->environment, status, "logStatus", line);
#else
    s->callbacks.logger(s->callbacks.componentEnvironment, s->name, status, "logStatus", "%s %g", text, value);
#endif
}

static int get_real(const Data *d, Reference v, double *value) {
    if (v >= REALS || (v == RATE && d->mute)) return 0;
    *value = v == Z ? d->r[GAIN] * d->r[U] : d->r[v];
    return 1;
}

static int set_real(Data *d, Reference v, double value) {
    if (v >= REALS) return 0;
    d->r[v] = value;
    if (v == U) d->slope = d->curvature = 0.0;
    return 1;
}

static int get_integer(const Data *d, Reference v, int *value) {
    if (v != FAIL_STATUS && v != STEPS && v != SWITCHED) return 0;
    *value = v == FAIL_STATUS ? d->fail_status : v == STEPS ? d->steps : d->switched;
    return 1;
}

static int set_integer(Data *d, Reference v, int value) {
    if (v != FAIL_STATUS && v != SWITCHED) return 0;
    *(v == FAIL_STATUS ? &d->fail_status : &d->switched) = value;
    return 1;
}

static int get_boolean(const Data *d, Reference v, Boolean *value) {
    if (v != ON && v != OFF) return 0;
    *value = v == ON ? d->on != 0 : !d->on;
    return 1;
}

static int set_boolean(Data *d, Reference v, Boolean value) {
    if (v != ON) return 0;
    d->on = value;
    return 1;
}

static int get_string(const Data *d, Reference v, const char **value) {
    if (v != LABEL) return 0;
    *value = d->label;
    return 1;
}

static int set_string(Data *d, Reference v, const char *value) {
    if (v != LABEL) return 0;
    snprintf(d->label, sizeof d->label, "%s", value);
    return 1;
}

static int save(const void *data, void **state) {
    if (!*state) *state = malloc(sizeof(Data));
    memcpy(*state, data, sizeof(Data));
    return OK;
}

/* The body of a function that reads or writes n values. */
#define EACH(passed) { for (size_t k = 0; k < n; k++) if (!(passed)) return ERROR; return OK; }

#ifdef __linux__
/* As programs do that close or use what they did not open. */
static void write_junk(int last) {
    for (int fd = 3; fd <= last; fd++) {
        char name[32], target[256];
        snprintf(name, sizeof name, "/proc/self/fd/%d", fd);
        ssize_t n = readlink(name, target, sizeof target - 1);
        if (n < 0) continue;
        target[n] = 0;
        if (target[0] != '/' && write(fd, "junk that is no answer to anything", 34) < 0) continue;
    }
}
#endif

static int advance(Slave *s, double t, double h) {
    Data *d = &s->data;
    if (h > d->r[LARGEST_STEP] * (1 + 1e-12)) {
        complain(s, DISCARD, "the step is above", d->r[LARGEST_STEP]);
        return DISCARD;
    }
    if (t + h > d->r[FAIL_AT]) {
        switch (d->fail_status) {
        case 5: raise(SIGSEGV); break;
        case 6: for (;;) ; break;
        case 7: d->r[Y] = NAN; return OK;
        case 8: exit(0);
        case 9: if (chdir("/")) return ERROR; break;
        case 10: fesetround(FE_UPWARD); break;
        case 11: setlocale(LC_ALL, "C"); break;
        case 12: printf("printed by the FMU\n"); break;
#ifndef _WIN32
        case 13: fork(); break;
#endif
        case 14: for (;;) { char *p = malloc(1 << 24); if (!p) abort(); memset(p, 1, 1 << 24); }
        case 15: d->mute = 1; break;
#ifdef __linux__
        case 16: write_junk(255); break;
        case 17: write_junk(65535); break;
        case 19: feenableexcept(FE_INVALID | FE_DIVBYZERO); break;
#endif
        case 18: { char *p = malloc(24); memset(p, 0x41, 4096); free(p); free(malloc(3000)); abort(); }
#ifdef __SSE2__
        case 20: _mm_setcsr(_mm_getcsr() | 0x8040); break;
#endif
        default: complain(s, d->fail_status, "it fails from", d->r[FAIL_AT]); return d->fail_status;
        }
    }
    d->r[Y] += d->r[RATE] * h * (d->r[U] + h * (d->slope / 2 + h * d->curvature / 6));
    d->r[U] += h * (d->slope + h * d->curvature / 2);
    d->slope = d->curvature = 0.0;
    d->steps++;
    return OK;
}

#ifdef FMI3
#include "trivial_fmi3.h"
#else
#include "trivial_fmi2.h"
#endif
