/* FMI 2.0 for co-simulation: one model with variables of type Real. Declarations follow the standard. */
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include "model.h"

#if defined(_WIN32)
#define EXPORT __declspec(dllexport)
#else
#define EXPORT __attribute__((visibility("default")))
#endif

typedef void *Instance;
typedef void *State;
typedef unsigned int Reference;
typedef const char *String;
typedef int Boolean;
typedef enum { OK, WARNING, DISCARD, ERROR, FATAL, PENDING } Status;

EXPORT const char *fmi2GetTypesPlatform(void) { return "default"; }

EXPORT const char *fmi2GetVersion(void) { return "2.0"; }

EXPORT Status fmi2SetDebugLogging(Instance c, Boolean on, size_t n, const String names[])
{
    (void)c, (void)on, (void)n, (void)names;
    return OK;
}

EXPORT Instance fmi2Instantiate(String name, int kind, String token, String resources, const void *callbacks,
    Boolean visible, Boolean logging)
{
    (void)name, (void)resources, (void)callbacks, (void)visible, (void)logging;
    if (kind != 1 || token == NULL || strcmp(token, MODEL_TOKEN) != 0) { /* 1: co-simulation */
        return NULL;
    }
    Model *model = calloc(1, sizeof(Model));
    if (model != NULL) {
        model_start(model);
    }
    return model;
}

EXPORT void fmi2FreeInstance(Instance c) { free(c); }

EXPORT Status fmi2SetupExperiment(Instance c, Boolean has_tolerance, double tolerance, double start,
    Boolean has_stop, double stop)
{
    (void)has_tolerance, (void)tolerance, (void)has_stop, (void)stop;
    ((Model *)c)->values[0] = start;
    return OK;
}

EXPORT Status fmi2EnterInitializationMode(Instance c)
{
    (void)c;
    return OK;
}

EXPORT Status fmi2ExitInitializationMode(Instance c)
{
    (void)c;
    return OK;
}

EXPORT Status fmi2Terminate(Instance c)
{
    (void)c;
    return OK;
}

EXPORT Status fmi2Reset(Instance c)
{
    memset(c, 0, sizeof(Model));
    model_start((Model *)c);
    return OK;
}

EXPORT Status fmi2GetReal(Instance c, const Reference at[], size_t n, double values[])
{
    const Model *model = c;
    for (size_t i = 0; i < n; i++) {
        if (at[i] >= MODEL_VARIABLES) {
            return ERROR;
        }
        values[i] = model->values[at[i]];
    }
    return OK;
}

EXPORT Status fmi2SetReal(Instance c, const Reference at[], size_t n, const double values[])
{
    Model *model = c;
    for (size_t i = 0; i < n; i++) {
        if (at[i] < 1 || at[i] > MODEL_INPUTS) {
            return ERROR;
        }
        model->values[at[i]] = values[i];
    }
    return OK;
}

EXPORT Status fmi2DoStep(Instance c, double t, double step, Boolean no_return)
{
    Model *model = c;
    (void)no_return;
    if (!(step > 0.0)) {
        return ERROR;
    }
    model_step(model, step);
    model->values[0] = t + step;
    return OK;
}

/* What follows belongs to other kinds of models; the standard asks that it exists. */
EXPORT Status fmi2GetInteger(Instance c, const Reference at[], size_t n, int values[])
{
    (void)c, (void)at, (void)n, (void)values;
    return n == 0 ? OK : ERROR;
}

EXPORT Status fmi2SetInteger(Instance c, const Reference at[], size_t n, const int values[])
{
    (void)c, (void)at, (void)n, (void)values;
    return n == 0 ? OK : ERROR;
}

EXPORT Status fmi2GetBoolean(Instance c, const Reference at[], size_t n, Boolean values[])
{
    (void)c, (void)at, (void)n, (void)values;
    return n == 0 ? OK : ERROR;
}

EXPORT Status fmi2SetBoolean(Instance c, const Reference at[], size_t n, const Boolean values[])
{
    (void)c, (void)at, (void)n, (void)values;
    return n == 0 ? OK : ERROR;
}

EXPORT Status fmi2GetString(Instance c, const Reference at[], size_t n, String values[])
{
    (void)c, (void)at, (void)n, (void)values;
    return n == 0 ? OK : ERROR;
}

EXPORT Status fmi2SetString(Instance c, const Reference at[], size_t n, const String values[])
{
    (void)c, (void)at, (void)n, (void)values;
    return n == 0 ? OK : ERROR;
}

EXPORT Status fmi2GetFMUstate(Instance c, State *state)
{
    (void)c, (void)state;
    return ERROR;
}

EXPORT Status fmi2SetFMUstate(Instance c, State state)
{
    (void)c, (void)state;
    return ERROR;
}

EXPORT Status fmi2FreeFMUstate(Instance c, State *state)
{
    (void)c, (void)state;
    return ERROR;
}

EXPORT Status fmi2SerializedFMUstateSize(Instance c, State state, size_t *size)
{
    (void)c, (void)state, (void)size;
    return ERROR;
}

EXPORT Status fmi2SerializeFMUstate(Instance c, State state, char data[], size_t size)
{
    (void)c, (void)state, (void)data, (void)size;
    return ERROR;
}

EXPORT Status fmi2DeSerializeFMUstate(Instance c, const char data[], size_t size, State *state)
{
    (void)c, (void)data, (void)size, (void)state;
    return ERROR;
}

EXPORT Status fmi2GetDirectionalDerivative(Instance c, const Reference unknowns[], size_t n_unknowns,
    const Reference knowns[], size_t n_knowns, const double seed[], double sensitivity[])
{
    (void)c, (void)unknowns, (void)n_unknowns, (void)knowns, (void)n_knowns, (void)seed, (void)sensitivity;
    return ERROR;
}

EXPORT Status fmi2SetRealInputDerivatives(Instance c, const Reference at[], size_t n, const int orders[],
    const double values[])
{
    (void)c, (void)at, (void)n, (void)orders, (void)values;
    return ERROR;
}

EXPORT Status fmi2GetRealOutputDerivatives(Instance c, const Reference at[], size_t n, const int orders[],
    double values[])
{
    (void)c, (void)at, (void)n, (void)orders, (void)values;
    return ERROR;
}

EXPORT Status fmi2CancelStep(Instance c)
{
    (void)c;
    return ERROR;
}

EXPORT Status fmi2GetStatus(Instance c, int kind, Status *value)
{
    (void)c, (void)kind, (void)value;
    return DISCARD;
}

EXPORT Status fmi2GetRealStatus(Instance c, int kind, double *value)
{
    (void)c, (void)kind, (void)value;
    return DISCARD;
}

EXPORT Status fmi2GetIntegerStatus(Instance c, int kind, int *value)
{
    (void)c, (void)kind, (void)value;
    return DISCARD;
}

EXPORT Status fmi2GetBooleanStatus(Instance c, int kind, Boolean *value)
{
    (void)c, (void)kind, (void)value;
    return DISCARD;
}

EXPORT Status fmi2GetStringStatus(Instance c, int kind, String *value)
{
    (void)c, (void)kind, (void)value;
    return DISCARD;
}
