/* FMI 3.0 for co-simulation: one model with variables of type Float64. Declarations follow the standard. */
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
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
typedef uint32_t Reference;
typedef const char *String;
typedef enum { OK, WARNING, DISCARD, ERROR, FATAL } Status;

EXPORT const char *fmi3GetVersion(void) { return "3.0"; }

EXPORT Status fmi3SetDebugLogging(Instance c, bool on, size_t n, const String names[])
{
    (void)c, (void)on, (void)n, (void)names;
    return OK;
}

EXPORT Instance fmi3InstantiateCoSimulation(String name, String token, String resources, bool visible, bool logging,
    bool events, bool early, const Reference needed[], size_t n, void *environment, void *log, void *update)
{
    (void)name, (void)resources, (void)visible, (void)logging, (void)events, (void)early, (void)needed, (void)n;
    (void)environment, (void)log, (void)update;
    if (token == NULL || strcmp(token, MODEL_TOKEN) != 0) {
        return NULL;
    }
    Model *model = calloc(1, sizeof(Model));
    if (model != NULL) {
        model_start(model);
    }
    return model;
}

EXPORT void fmi3FreeInstance(Instance c) { free(c); }

EXPORT Status fmi3EnterInitializationMode(Instance c, bool has_tolerance, double tolerance, double start,
    bool has_stop, double stop)
{
    (void)has_tolerance, (void)tolerance, (void)has_stop, (void)stop;
    ((Model *)c)->values[0] = start;
    return OK;
}

EXPORT Status fmi3ExitInitializationMode(Instance c)
{
    (void)c;
    return OK;
}

EXPORT Status fmi3Terminate(Instance c)
{
    (void)c;
    return OK;
}

EXPORT Status fmi3Reset(Instance c)
{
    memset(c, 0, sizeof(Model));
    model_start((Model *)c);
    return OK;
}

EXPORT Status fmi3GetFloat64(Instance c, const Reference at[], size_t n, double values[], size_t n_values)
{
    const Model *model = c;
    if (n != n_values) {
        return ERROR;
    }
    for (size_t i = 0; i < n; i++) {
        if (at[i] >= MODEL_VARIABLES) {
            return ERROR;
        }
        values[i] = model->values[at[i]];
    }
    return OK;
}

EXPORT Status fmi3SetFloat64(Instance c, const Reference at[], size_t n, const double values[], size_t n_values)
{
    Model *model = c;
    if (n != n_values) {
        return ERROR;
    }
    for (size_t i = 0; i < n; i++) {
        if (at[i] < 1 || at[i] > MODEL_INPUTS) {
            return ERROR;
        }
        model->values[at[i]] = values[i];
    }
    return OK;
}

EXPORT Status fmi3DoStep(Instance c, double t, double step, bool no_return, bool *event, bool *terminate,
    bool *early, double *last)
{
    Model *model = c;
    (void)no_return;
    *event = *terminate = *early = false;
    *last = t;
    if (!(step > 0.0)) {
        return ERROR;
    }
    model_step(model, step);
    *last = model->values[0] = t + step;
    return OK;
}

/* What follows belongs to other kinds of models; the standard asks that it exists. */
EXPORT Instance fmi3InstantiateModelExchange(String name, String token, String resources, bool visible,
    bool logging, void *environment, void *log)
{
    (void)name, (void)token, (void)resources, (void)visible, (void)logging, (void)environment, (void)log;
    return NULL;
}

EXPORT Instance fmi3InstantiateScheduledExecution(String name, String token, String resources,
    bool visible, bool logging, void *environment, void *log, void *update, void *lock, void *unlock)
{
    (void)name, (void)token, (void)resources, (void)visible, (void)logging, (void)environment, (void)log, (void)update, (void)lock, (void)unlock;
    return NULL;
}

EXPORT Status fmi3EnterConfigurationMode(Instance c)
{
    (void)c;
    return ERROR;
}

EXPORT Status fmi3ExitConfigurationMode(Instance c)
{
    (void)c;
    return ERROR;
}

EXPORT Status fmi3EnterEventMode(Instance c)
{
    (void)c;
    return ERROR;
}

EXPORT Status fmi3EnterStepMode(Instance c)
{
    (void)c;
    return ERROR;
}

EXPORT Status fmi3EnterContinuousTimeMode(Instance c)
{
    (void)c;
    return ERROR;
}

EXPORT Status fmi3EvaluateDiscreteStates(Instance c)
{
    (void)c;
    return ERROR;
}

EXPORT Status fmi3GetFloat32(Instance c, const Reference at[], size_t n, float values[], size_t n_values)
{
    (void)c, (void)at, (void)n, (void)values, (void)n_values;
    return n == 0 && n_values == 0 ? OK : ERROR;
}

EXPORT Status fmi3SetFloat32(Instance c, const Reference at[], size_t n, const float values[],
    size_t n_values)
{
    (void)c, (void)at, (void)n, (void)values, (void)n_values;
    return n == 0 && n_values == 0 ? OK : ERROR;
}

EXPORT Status fmi3GetInt8(Instance c, const Reference at[], size_t n, int8_t values[], size_t n_values)
{
    (void)c, (void)at, (void)n, (void)values, (void)n_values;
    return n == 0 && n_values == 0 ? OK : ERROR;
}

EXPORT Status fmi3SetInt8(Instance c, const Reference at[], size_t n, const int8_t values[], size_t n_values)
{
    (void)c, (void)at, (void)n, (void)values, (void)n_values;
    return n == 0 && n_values == 0 ? OK : ERROR;
}

EXPORT Status fmi3GetUInt8(Instance c, const Reference at[], size_t n, uint8_t values[], size_t n_values)
{
    (void)c, (void)at, (void)n, (void)values, (void)n_values;
    return n == 0 && n_values == 0 ? OK : ERROR;
}

EXPORT Status fmi3SetUInt8(Instance c, const Reference at[], size_t n, const uint8_t values[],
    size_t n_values)
{
    (void)c, (void)at, (void)n, (void)values, (void)n_values;
    return n == 0 && n_values == 0 ? OK : ERROR;
}

EXPORT Status fmi3GetInt16(Instance c, const Reference at[], size_t n, int16_t values[], size_t n_values)
{
    (void)c, (void)at, (void)n, (void)values, (void)n_values;
    return n == 0 && n_values == 0 ? OK : ERROR;
}

EXPORT Status fmi3SetInt16(Instance c, const Reference at[], size_t n, const int16_t values[],
    size_t n_values)
{
    (void)c, (void)at, (void)n, (void)values, (void)n_values;
    return n == 0 && n_values == 0 ? OK : ERROR;
}

EXPORT Status fmi3GetUInt16(Instance c, const Reference at[], size_t n, uint16_t values[], size_t n_values)
{
    (void)c, (void)at, (void)n, (void)values, (void)n_values;
    return n == 0 && n_values == 0 ? OK : ERROR;
}

EXPORT Status fmi3SetUInt16(Instance c, const Reference at[], size_t n, const uint16_t values[],
    size_t n_values)
{
    (void)c, (void)at, (void)n, (void)values, (void)n_values;
    return n == 0 && n_values == 0 ? OK : ERROR;
}

EXPORT Status fmi3GetInt32(Instance c, const Reference at[], size_t n, int32_t values[], size_t n_values)
{
    (void)c, (void)at, (void)n, (void)values, (void)n_values;
    return n == 0 && n_values == 0 ? OK : ERROR;
}

EXPORT Status fmi3SetInt32(Instance c, const Reference at[], size_t n, const int32_t values[],
    size_t n_values)
{
    (void)c, (void)at, (void)n, (void)values, (void)n_values;
    return n == 0 && n_values == 0 ? OK : ERROR;
}

EXPORT Status fmi3GetUInt32(Instance c, const Reference at[], size_t n, uint32_t values[], size_t n_values)
{
    (void)c, (void)at, (void)n, (void)values, (void)n_values;
    return n == 0 && n_values == 0 ? OK : ERROR;
}

EXPORT Status fmi3SetUInt32(Instance c, const Reference at[], size_t n, const uint32_t values[],
    size_t n_values)
{
    (void)c, (void)at, (void)n, (void)values, (void)n_values;
    return n == 0 && n_values == 0 ? OK : ERROR;
}

EXPORT Status fmi3GetInt64(Instance c, const Reference at[], size_t n, int64_t values[], size_t n_values)
{
    (void)c, (void)at, (void)n, (void)values, (void)n_values;
    return n == 0 && n_values == 0 ? OK : ERROR;
}

EXPORT Status fmi3SetInt64(Instance c, const Reference at[], size_t n, const int64_t values[],
    size_t n_values)
{
    (void)c, (void)at, (void)n, (void)values, (void)n_values;
    return n == 0 && n_values == 0 ? OK : ERROR;
}

EXPORT Status fmi3GetUInt64(Instance c, const Reference at[], size_t n, uint64_t values[], size_t n_values)
{
    (void)c, (void)at, (void)n, (void)values, (void)n_values;
    return n == 0 && n_values == 0 ? OK : ERROR;
}

EXPORT Status fmi3SetUInt64(Instance c, const Reference at[], size_t n, const uint64_t values[],
    size_t n_values)
{
    (void)c, (void)at, (void)n, (void)values, (void)n_values;
    return n == 0 && n_values == 0 ? OK : ERROR;
}

EXPORT Status fmi3GetBoolean(Instance c, const Reference at[], size_t n, bool values[], size_t n_values)
{
    (void)c, (void)at, (void)n, (void)values, (void)n_values;
    return n == 0 && n_values == 0 ? OK : ERROR;
}

EXPORT Status fmi3SetBoolean(Instance c, const Reference at[], size_t n, const bool values[], size_t n_values)
{
    (void)c, (void)at, (void)n, (void)values, (void)n_values;
    return n == 0 && n_values == 0 ? OK : ERROR;
}

EXPORT Status fmi3GetString(Instance c, const Reference at[], size_t n, String values[], size_t n_values)
{
    (void)c, (void)at, (void)n, (void)values, (void)n_values;
    return n == 0 && n_values == 0 ? OK : ERROR;
}

EXPORT Status fmi3SetString(Instance c, const Reference at[], size_t n, const String values[],
    size_t n_values)
{
    (void)c, (void)at, (void)n, (void)values, (void)n_values;
    return n == 0 && n_values == 0 ? OK : ERROR;
}

EXPORT Status fmi3GetBinary(Instance c, const Reference at[], size_t n, size_t sizes[],
    const uint8_t *values[], size_t n_values)
{
    (void)c, (void)at, (void)n, (void)sizes, (void)values, (void)n_values;
    return ERROR;
}

EXPORT Status fmi3SetBinary(Instance c, const Reference at[], size_t n, const size_t sizes[],
    const uint8_t *const values[], size_t n_values)
{
    (void)c, (void)at, (void)n, (void)sizes, (void)values, (void)n_values;
    return ERROR;
}

EXPORT Status fmi3GetClock(Instance c, const Reference at[], size_t n, bool values[])
{
    (void)c, (void)at, (void)n, (void)values;
    return ERROR;
}

EXPORT Status fmi3SetClock(Instance c, const Reference at[], size_t n, const bool values[])
{
    (void)c, (void)at, (void)n, (void)values;
    return ERROR;
}

EXPORT Status fmi3GetNumberOfVariableDependencies(Instance c, Reference at, size_t *count)
{
    (void)c, (void)at, (void)count;
    return ERROR;
}

EXPORT Status fmi3GetVariableDependencies(Instance c, Reference at, size_t elements[],
    Reference independents[], size_t independent_elements[], int kinds[], size_t count)
{
    (void)c, (void)at, (void)elements, (void)independents, (void)independent_elements, (void)kinds, (void)count;
    return ERROR;
}

EXPORT Status fmi3GetFMUState(Instance c, State *state)
{
    (void)c, (void)state;
    return ERROR;
}

EXPORT Status fmi3SetFMUState(Instance c, State state)
{
    (void)c, (void)state;
    return ERROR;
}

EXPORT Status fmi3FreeFMUState(Instance c, State *state)
{
    (void)c, (void)state;
    return ERROR;
}

EXPORT Status fmi3SerializedFMUStateSize(Instance c, State state, size_t *size)
{
    (void)c, (void)state, (void)size;
    return ERROR;
}

EXPORT Status fmi3SerializeFMUState(Instance c, State state, uint8_t data[], size_t size)
{
    (void)c, (void)state, (void)data, (void)size;
    return ERROR;
}

EXPORT Status fmi3DeserializeFMUState(Instance c, const uint8_t data[], size_t size, State *state)
{
    (void)c, (void)data, (void)size, (void)state;
    return ERROR;
}

EXPORT Status fmi3GetDirectionalDerivative(Instance c, const Reference unknowns[], size_t n_unknowns,
    const Reference knowns[], size_t n_knowns, const double seed[], size_t n_seed, double sensitivity[],
    size_t n_sensitivity)
{
    (void)c, (void)unknowns, (void)n_unknowns, (void)knowns, (void)n_knowns, (void)seed, (void)n_seed, (void)sensitivity, (void)n_sensitivity;
    return ERROR;
}

EXPORT Status fmi3GetAdjointDerivative(Instance c, const Reference unknowns[], size_t n_unknowns,
    const Reference knowns[], size_t n_knowns, const double seed[], size_t n_seed, double sensitivity[],
    size_t n_sensitivity)
{
    (void)c, (void)unknowns, (void)n_unknowns, (void)knowns, (void)n_knowns, (void)seed, (void)n_seed, (void)sensitivity, (void)n_sensitivity;
    return ERROR;
}

EXPORT Status fmi3GetIntervalDecimal(Instance c, const Reference at[], size_t n, double intervals[],
    int qualifiers[])
{
    (void)c, (void)at, (void)n, (void)intervals, (void)qualifiers;
    return ERROR;
}

EXPORT Status fmi3GetIntervalFraction(Instance c, const Reference at[], size_t n, uint64_t counters[],
    uint64_t resolutions[], int qualifiers[])
{
    (void)c, (void)at, (void)n, (void)counters, (void)resolutions, (void)qualifiers;
    return ERROR;
}

EXPORT Status fmi3GetShiftDecimal(Instance c, const Reference at[], size_t n, double shifts[])
{
    (void)c, (void)at, (void)n, (void)shifts;
    return ERROR;
}

EXPORT Status fmi3GetShiftFraction(Instance c, const Reference at[], size_t n, uint64_t counters[],
    uint64_t resolutions[])
{
    (void)c, (void)at, (void)n, (void)counters, (void)resolutions;
    return ERROR;
}

EXPORT Status fmi3SetIntervalDecimal(Instance c, const Reference at[], size_t n, const double intervals[])
{
    (void)c, (void)at, (void)n, (void)intervals;
    return ERROR;
}

EXPORT Status fmi3SetIntervalFraction(Instance c, const Reference at[], size_t n,
    const uint64_t counters[], const uint64_t resolutions[])
{
    (void)c, (void)at, (void)n, (void)counters, (void)resolutions;
    return ERROR;
}

EXPORT Status fmi3SetShiftDecimal(Instance c, const Reference at[], size_t n, const double shifts[])
{
    (void)c, (void)at, (void)n, (void)shifts;
    return ERROR;
}

EXPORT Status fmi3SetShiftFraction(Instance c, const Reference at[], size_t n, const uint64_t counters[],
    const uint64_t resolutions[])
{
    (void)c, (void)at, (void)n, (void)counters, (void)resolutions;
    return ERROR;
}

EXPORT Status fmi3UpdateDiscreteStates(Instance c, bool *again, bool *terminate, bool *nominals,
    bool *changed, bool *defined, double *next)
{
    (void)c, (void)again, (void)terminate, (void)nominals, (void)changed, (void)defined, (void)next;
    return ERROR;
}

EXPORT Status fmi3CompletedIntegratorStep(Instance c, bool done, bool *event, bool *terminate)
{
    (void)c, (void)done, (void)event, (void)terminate;
    return ERROR;
}

EXPORT Status fmi3SetTime(Instance c, double t)
{
    (void)c, (void)t;
    return ERROR;
}

EXPORT Status fmi3SetContinuousStates(Instance c, const double states[], size_t n)
{
    (void)c, (void)states, (void)n;
    return ERROR;
}

EXPORT Status fmi3GetContinuousStateDerivatives(Instance c, double values[], size_t n)
{
    (void)c, (void)values, (void)n;
    return ERROR;
}

EXPORT Status fmi3GetEventIndicators(Instance c, double values[], size_t n)
{
    (void)c, (void)values, (void)n;
    return ERROR;
}

EXPORT Status fmi3GetContinuousStates(Instance c, double values[], size_t n)
{
    (void)c, (void)values, (void)n;
    return ERROR;
}

EXPORT Status fmi3GetNominalsOfContinuousStates(Instance c, double values[], size_t n)
{
    (void)c, (void)values, (void)n;
    return ERROR;
}

EXPORT Status fmi3GetNumberOfEventIndicators(Instance c, size_t *n)
{
    (void)c, (void)n;
    return ERROR;
}

EXPORT Status fmi3GetNumberOfContinuousStates(Instance c, size_t *n)
{
    (void)c, (void)n;
    return ERROR;
}

EXPORT Status fmi3GetOutputDerivatives(Instance c, const Reference at[], size_t n, const int32_t orders[],
    double values[], size_t n_values)
{
    (void)c, (void)at, (void)n, (void)orders, (void)values, (void)n_values;
    return ERROR;
}

EXPORT Status fmi3ActivateModelPartition(Instance c, Reference clock, double t)
{
    (void)c, (void)clock, (void)t;
    return ERROR;
}
