/* A pendulum as an FMU of FMI 2.0 and 3.0, for co-simulation and model exchange; macros plant mistakes. */
#include <math.h>
#include <signal.h>
#include <stddef.h>
#include <stdlib.h>
#include <unistd.h>

typedef unsigned int reference;
enum { OK, WARNING, DISCARD, ERROR };
enum { THETA, OMEGA, SLOPE, BEND, GRAVITY, LENGTH, COUNT }; /* the value references */
typedef struct { double values[COUNT], before[2]; } model;
typedef struct { int more, terminate, nominals, values, has_next; double next; } events;

#ifndef GRAVITY_FACTOR
#define GRAVITY_FACTOR 1.0
#endif

#ifndef UNIT
#define UNIT 1.0 /* of theta, in radians */
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
#ifdef NO_START
    return ERROR;
#endif
    m->before[0] = m->values[THETA];
    m->before[1] = m->values[OMEGA];
    return OK;
}
int fmi2SetReal(model *m, const reference *r, size_t n, const double *values)
{
    for (size_t i = 0; i < n; i++) m->values[r[i]] = r[i] == THETA ? values[i] / UNIT : values[i];
    return OK;
}
int fmi2GetReal(model *m, const reference *r, size_t n, double *values)
{
    for (size_t i = 0; i < n; i++) {
        values[i] = m->values[r[i]];
#ifdef LATE
        if (r[i] < 2) values[i] = m->before[r[i]];
#endif
        if (r[i] == THETA) values[i] *= UNIT;
    }
    return OK;
}
int fmi2DoStep(model *m, double t, double h, int final)
{
#ifdef CRASHES
    if (t > 1) {
        signal(SIGABRT, SIG_DFL); /* without a traceback of Python */
        abort();
    }
#endif
#ifdef HANGS
    while (t > 1) sleep(1);
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

/* FMI 3.0 */
void *fmi3InstantiateCoSimulation(const char *name) { return fmi2Instantiate(name, 0, 0, 0, 0, 0, 0); }
void *fmi3InstantiateModelExchange(const char *name) { return fmi2Instantiate(name, 0, 0, 0, 0, 0, 0); }
void fmi3FreeInstance(void *m) { free(m); }
int fmi3EnterInitializationMode(void *m) { return OK; }
int fmi3ExitInitializationMode(model *m) { return fmi2ExitInitializationMode(m); }
int fmi3SetFloat64(model *m, const reference *r, size_t n, const double *values) { return fmi2SetReal(m, r, n, values); }
int fmi3GetFloat64(model *m, const reference *r, size_t n, double *values) { return fmi2GetReal(m, r, n, values); }
int fmi3DoStep(model *m, double t, double h, _Bool final, _Bool *event, _Bool *terminate, _Bool *early, double *last)
{
    *event = *terminate = *early = 0;
    *last = t + h;
    return fmi2DoStep(m, t, h, final);
}
int fmi3UpdateDiscreteStates(void *m, _Bool *more, _Bool *terminate, _Bool *nominals, _Bool *values, _Bool *has_next, double *next)
{
    *more = *terminate = *nominals = *values = *has_next = 0;
    return OK;
}
int fmi3EnterContinuousTimeMode(void *m) { return OK; }
int fmi3SetTime(void *m, double t) { return OK; }
int fmi3SetContinuousStates(model *m, const double *x, size_t n) { return fmi2SetContinuousStates(m, x, n); }
int fmi3GetContinuousStateDerivatives(model *m, double *f, size_t n) { return fmi2GetDerivatives(m, f, n); }

#define NOT_CALLED_3(name) int fmi3##name(void) { return ERROR; }
NOT_CALLED_3(ActivateModelPartition)
NOT_CALLED_3(CompletedIntegratorStep)
NOT_CALLED_3(DeserializeFMUState)
NOT_CALLED_3(EnterConfigurationMode)
NOT_CALLED_3(EnterEventMode)
NOT_CALLED_3(EnterStepMode)
NOT_CALLED_3(EvaluateDiscreteStates)
NOT_CALLED_3(ExitConfigurationMode)
NOT_CALLED_3(FreeFMUState)
NOT_CALLED_3(GetAdjointDerivative)
NOT_CALLED_3(GetBinary)
NOT_CALLED_3(GetBoolean)
NOT_CALLED_3(GetClock)
NOT_CALLED_3(GetContinuousStates)
NOT_CALLED_3(GetDirectionalDerivative)
NOT_CALLED_3(GetEventIndicators)
NOT_CALLED_3(GetFMUState)
NOT_CALLED_3(GetFloat32)
NOT_CALLED_3(GetInt16)
NOT_CALLED_3(GetInt32)
NOT_CALLED_3(GetInt64)
NOT_CALLED_3(GetInt8)
NOT_CALLED_3(GetIntervalDecimal)
NOT_CALLED_3(GetIntervalFraction)
NOT_CALLED_3(GetNominalsOfContinuousStates)
NOT_CALLED_3(GetNumberOfContinuousStates)
NOT_CALLED_3(GetNumberOfEventIndicators)
NOT_CALLED_3(GetNumberOfVariableDependencies)
NOT_CALLED_3(GetOutputDerivatives)
NOT_CALLED_3(GetShiftDecimal)
NOT_CALLED_3(GetShiftFraction)
NOT_CALLED_3(GetString)
NOT_CALLED_3(GetUInt16)
NOT_CALLED_3(GetUInt32)
NOT_CALLED_3(GetUInt64)
NOT_CALLED_3(GetUInt8)
NOT_CALLED_3(GetVariableDependencies)
NOT_CALLED_3(GetVersion)
NOT_CALLED_3(InstantiateScheduledExecution)
NOT_CALLED_3(Reset)
NOT_CALLED_3(SerializeFMUState)
NOT_CALLED_3(SerializedFMUStateSize)
NOT_CALLED_3(SetBinary)
NOT_CALLED_3(SetBoolean)
NOT_CALLED_3(SetClock)
NOT_CALLED_3(SetDebugLogging)
NOT_CALLED_3(SetFMUState)
NOT_CALLED_3(SetFloat32)
NOT_CALLED_3(SetInt16)
NOT_CALLED_3(SetInt32)
NOT_CALLED_3(SetInt64)
NOT_CALLED_3(SetInt8)
NOT_CALLED_3(SetIntervalDecimal)
NOT_CALLED_3(SetIntervalFraction)
NOT_CALLED_3(SetShiftDecimal)
NOT_CALLED_3(SetShiftFraction)
NOT_CALLED_3(SetString)
NOT_CALLED_3(SetUInt16)
NOT_CALLED_3(SetUInt32)
NOT_CALLED_3(SetUInt64)
NOT_CALLED_3(SetUInt8)
NOT_CALLED_3(Terminate)
