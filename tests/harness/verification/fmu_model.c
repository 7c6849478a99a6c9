/* A pendulum as an FMU of FMI 2.0, for co-simulation and model exchange; macros plant mistakes. */
#include <math.h>
#include <stddef.h>
#include <stdlib.h>

typedef unsigned int reference;
enum { OK, WARNING, DISCARD, ERROR };
enum { THETA, OMEGA, SLOPE, BEND, GRAVITY, LENGTH, COUNT }; /* the value references */
typedef struct { double values[COUNT], before[2]; } model;
typedef struct { int more, terminate, nominals, values, has_next; double next; } events;

#ifndef GRAVITY_FACTOR
#define GRAVITY_FACTOR 1.0
#endif

static void slopes(const model *m, const double *y, double *f)
{
    f[0] = y[1];
    f[1] = -GRAVITY_FACTOR * m->values[GRAVITY] / m->values[LENGTH] * sin(y[0]);
}

static void advance(model *m, double h)
{
    double *y = m->values, k[4][2], z[2];
    slopes(m, y, k[0]);
#ifdef EULER
    for (int i = 0; i < 2; i++) y[i] += h * k[0][i];
    (void)z;
#else
    const double share[3] = {0.5, 0.5, 1.0};
    for (int s = 0; s < 3; s++) {
        for (int i = 0; i < 2; i++) z[i] = y[i] + share[s] * h * k[s][i];
        slopes(m, z, k[s + 1]);
    }
    for (int i = 0; i < 2; i++) y[i] += h / 6 * (k[0][i] + 2 * k[1][i] + 2 * k[2][i] + k[3][i]);
#endif
}

const char *fmi2GetTypesPlatform(void) { return "default"; }
const char *fmi2GetVersion(void) { return "2.0"; }
void *fmi2Instantiate(const char *name, int type, const char *guid, const char *place, const void *callbacks, int visible, int logging)
{
    model *m = calloc(1, sizeof *m);
    m->values[THETA] = 2;
    m->values[GRAVITY] = 9.81;
    m->values[LENGTH] = 1;
    return m;
}
void fmi2FreeInstance(void *m) { free(m); }
int fmi2SetupExperiment(void *m, int has_tolerance, double tolerance, double start, int has_stop, double stop) { return OK; }
int fmi2EnterInitializationMode(void *m) { return OK; }
int fmi2ExitInitializationMode(model *m)
{
    m->before[0] = m->values[THETA];
    m->before[1] = m->values[OMEGA];
    return OK;
}
int fmi2SetReal(model *m, const reference *r, size_t n, const double *values)
{
    for (size_t i = 0; i < n; i++) m->values[r[i]] = values[i];
    return OK;
}
int fmi2GetReal(model *m, const reference *r, size_t n, double *values)
{
    for (size_t i = 0; i < n; i++) {
        values[i] = m->values[r[i]];
#ifdef LATE
        if (r[i] < 2) values[i] = m->before[r[i]];
#endif
    }
    return OK;
}
int fmi2DoStep(model *m, double t, double h, int final)
{
#ifdef CRASHES
    if (t > 1) abort();
#endif
#ifdef HANGS
    while (t > 1) ;
#endif
    m->before[0] = m->values[THETA];
    m->before[1] = m->values[OMEGA];
    advance(m, h);
    return OK;
}
int fmi2NewDiscreteStates(void *m, events *found)
{
    *found = (events){0};
    return OK;
}
int fmi2EnterContinuousTimeMode(void *m) { return OK; }
int fmi2SetTime(void *m, double t) { return OK; }
int fmi2SetContinuousStates(model *m, const double *x, size_t n)
{
    for (size_t i = 0; i < n; i++) m->values[i] = x[i];
    return OK;
}
int fmi2GetDerivatives(model *m, double *f, size_t n)
{
    slopes(m, m->values, f);
    return OK;
}

/* fmpy looks up all functions; these are not called. */
#define NOT_CALLED(name) int fmi2##name(void) { return ERROR; }
NOT_CALLED(CancelStep)
NOT_CALLED(CompletedIntegratorStep)
NOT_CALLED(DeSerializeFMUstate)
NOT_CALLED(EnterEventMode)
NOT_CALLED(FreeFMUstate)
NOT_CALLED(GetBoolean)
NOT_CALLED(GetBooleanStatus)
NOT_CALLED(GetContinuousStates)
NOT_CALLED(GetDirectionalDerivative)
NOT_CALLED(GetEventIndicators)
NOT_CALLED(GetFMUstate)
NOT_CALLED(GetInteger)
NOT_CALLED(GetIntegerStatus)
NOT_CALLED(GetNominalsOfContinuousStates)
NOT_CALLED(GetRealOutputDerivatives)
NOT_CALLED(GetRealStatus)
NOT_CALLED(GetStatus)
NOT_CALLED(GetString)
NOT_CALLED(GetStringStatus)
NOT_CALLED(Reset)
NOT_CALLED(SerializeFMUstate)
NOT_CALLED(SerializedFMUstateSize)
NOT_CALLED(SetBoolean)
NOT_CALLED(SetDebugLogging)
NOT_CALLED(SetFMUstate)
NOT_CALLED(SetInteger)
NOT_CALLED(SetRealInputDerivatives)
NOT_CALLED(SetString)
NOT_CALLED(Terminate)
