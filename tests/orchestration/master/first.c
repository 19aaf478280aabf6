/* A slave of FMI 1.0: y' = k u by Euler's method, its negative by an alias, an integer that counts steps, the
 * boolean whether it was initialized with u above 1, a text; a step to a time beyond k fails. */
#include <stdlib.h>
#include <string.h>

typedef void (*Logger)(void *c, const char *name, int status, const char *category, const char *message, ...);
typedef struct { Logger logger; void *(*allocate)(size_t, size_t); void (*release)(void *); void *finished; } Callbacks;
typedef struct { double k, u, y, most; int steps; char large, begun; char text[16]; Callbacks callbacks; } Slave;
enum { K, U, Y, MOST };
#define FMI(name) First_fmi##name

const char *FMI(GetTypesPlatform)(void) { return "standard32"; }
const char *FMI(GetVersion)(void) { return "1.0"; }
int FMI(SetDebugLogging)(void *c, char on) { return 0; }
void *FMI(InstantiateSlave)(const char *name, const char *guid, const char *place, const char *kind, double patience,
                            char visible, char interactive, Callbacks callbacks, char logging)
{
    Slave *s = callbacks.allocate(1, sizeof *s);
    s->k = 2, s->most = 1e300, s->callbacks = callbacks;
    strcpy(s->text, strncmp(place, "file://", 7) ? "nowhere" : "somewhere");
    return s;
}
void FMI(FreeSlaveInstance)(Slave *s) { s->callbacks.release(s); }
int FMI(InitializeSlave)(Slave *s, double start, char ends, double stop)
{
    s->large = s->u > 1, s->begun = 1;
    return 0;
}
int FMI(TerminateSlave)(void *c) { return 0; }
int FMI(ResetSlave)(void *c) { return 0; }
int FMI(DoStep)(Slave *s, double t, double h, char accepted)
{
    if (!s->begun || !accepted || t + h > s->most) {
        s->callbacks.logger(s, "first", 3, "error", "no step beyond %g s", s->most);
        return 3;
    }
    s->y += h * s->k * s->u, s->steps++;
    return 0;
}
int FMI(GetReal)(Slave *s, const unsigned *v, size_t n, double *x)
{
    for (size_t i = 0; i < n; i++)
        x[i] = v[i] == Y ? s->y : v[i] == U ? s->u : v[i] == K ? s->k : s->most;
    return 0;
}
int FMI(SetReal)(Slave *s, const unsigned *v, size_t n, const double *x)
{
    for (size_t i = 0; i < n; i++)
        *(v[i] == Y ? &s->y : v[i] == U ? &s->u : v[i] == K ? &s->k : &s->most) = x[i];
    return 0;
}
int FMI(GetInteger)(Slave *s, const unsigned *v, size_t n, int *x) { return *x = s->steps, 0; }
int FMI(SetInteger)(Slave *s, const unsigned *v, size_t n, const int *x) { return s->steps = *x, 0; }
int FMI(GetBoolean)(Slave *s, const unsigned *v, size_t n, char *x) { return *x = s->large, 0; }
int FMI(SetBoolean)(void *c, const unsigned *v, size_t n, const char *x) { return 3; }
int FMI(GetString)(Slave *s, const unsigned *v, size_t n, const char **x) { return *x = s->text, 0; }
int FMI(SetString)(void *c, const unsigned *v, size_t n, const char **x) { return 3; }
int FMI(SetRealInputDerivatives)(void) { return 3; }
int FMI(GetRealOutputDerivatives)(void) { return 3; }
int FMI(CancelStep)(void) { return 3; }
int FMI(GetStatus)(void) { return 3; }
int FMI(GetRealStatus)(void) { return 3; }
int FMI(GetIntegerStatus)(void) { return 3; }
int FMI(GetBooleanStatus)(void) { return 3; }
int FMI(GetStringStatus)(void) { return 3; }
