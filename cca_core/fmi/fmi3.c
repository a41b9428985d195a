/* FMI 3.0 for co-simulation. Declarations follow the standard. */
#include "fmi.h"

EXPORT const char *fmi3GetVersion(void) { return "3.0"; }

EXPORT Status fmi3SetDebugLogging(Instance c, bool on, size_t n, const String names[]) { return OK; }

EXPORT Instance fmi3InstantiateCoSimulation(String name, String token, String resources, bool visible, bool logging,
    bool events, bool early, const Reference needed[], size_t n, void *environment, void *log, void *update)
{
    return instance(token);
}

EXPORT void fmi3FreeInstance(Instance c) { free(c); }

EXPORT Status fmi3EnterInitializationMode(Instance c, bool has_tolerance, double tolerance, double start,
    bool has_stop, double stop)
{
    return begin(c, start);
}

EXPORT Status fmi3ExitInitializationMode(Instance c) { return OK; }

EXPORT Status fmi3Terminate(Instance c) { return OK; }

EXPORT Status fmi3Reset(Instance c) { return reset(c); }

EXPORT Status fmi3GetFloat64(Instance c, const Reference at[], size_t n, double values[], size_t n_values)
{
    return n == n_values ? get_values(c, at, n, values) : ERROR;
}

EXPORT Status fmi3SetFloat64(Instance c, const Reference at[], size_t n, const double values[], size_t n_values)
{
    return n == n_values ? set_values(c, at, n, values) : ERROR;
}

EXPORT Status fmi3DoStep(Instance c, double t, double step, bool no_return, bool *event, bool *terminate,
    bool *early, double *last)
{
    const Status status = do_step(c, t, step);
    *event = *terminate = *early = false;
    *last = status == OK ? t + step : t;
    return status;
}

/* What follows belongs to other kinds of models; the standard asks that it exists. */
#define NO_VARIABLES(name, type) \
    EXPORT Status fmi3Get##name(Instance c, const Reference at[], size_t n, type values[], size_t n_values) \
    { \
        return n == 0 && n_values == 0 ? OK : ERROR; \
    } \
    EXPORT Status fmi3Set##name(Instance c, const Reference at[], size_t n, const type values[], size_t n_values) \
    { \
        return n == 0 && n_values == 0 ? OK : ERROR; \
    }

EXPORT Instance fmi3InstantiateModelExchange(String name, String token, String resources, bool visible, bool
    logging, void *environment, void *log)
{
    return NULL;
}

EXPORT Instance fmi3InstantiateScheduledExecution(String name, String token, String resources, bool visible,
    bool logging, void *environment, void *log, void *update, void *lock, void *unlock)
{
    return NULL;
}

NO_VARIABLES(Float32, float)
NO_VARIABLES(Int8, int8_t)
NO_VARIABLES(UInt8, uint8_t)
NO_VARIABLES(Int16, int16_t)
NO_VARIABLES(UInt16, uint16_t)
NO_VARIABLES(Int32, int32_t)
NO_VARIABLES(UInt32, uint32_t)
NO_VARIABLES(Int64, int64_t)
NO_VARIABLES(UInt64, uint64_t)
NO_VARIABLES(Boolean, bool)
NO_VARIABLES(String, String)
WITHOUT(fmi3GetBinary, const Reference at[], size_t n, size_t sizes[], const uint8_t *values[], size_t
    n_values)
WITHOUT(fmi3SetBinary, const Reference at[], size_t n, const size_t sizes[], const uint8_t *const values[],
    size_t n_values)
WITHOUT(fmi3GetClock, const Reference at[], size_t n, bool values[])
WITHOUT(fmi3SetClock, const Reference at[], size_t n, const bool values[])
WITHOUT(fmi3GetNumberOfVariableDependencies, Reference at, size_t *count)
WITHOUT(fmi3GetVariableDependencies, Reference at, size_t elements[], Reference independents[], size_t
    independent_elements[], int kinds[], size_t count)
WITHOUT(fmi3GetFMUState, State *state)
WITHOUT(fmi3SetFMUState, State state)
WITHOUT(fmi3FreeFMUState, State *state)
WITHOUT(fmi3SerializedFMUStateSize, State state, size_t *size)
WITHOUT(fmi3SerializeFMUState, State state, uint8_t data[], size_t size)
WITHOUT(fmi3DeserializeFMUState, const uint8_t data[], size_t size, State *state)
WITHOUT(fmi3GetDirectionalDerivative, const Reference unknowns[], size_t n_unknowns, const Reference knowns[],
    size_t n_knowns, const double seed[], size_t n_seed, double sensitivity[], size_t n_sensitivity)
WITHOUT(fmi3GetAdjointDerivative, const Reference unknowns[], size_t n_unknowns, const Reference knowns[],
    size_t n_knowns, const double seed[], size_t n_seed, double sensitivity[], size_t n_sensitivity)
WITHOUT(fmi3GetIntervalDecimal, const Reference at[], size_t n, double intervals[], int qualifiers[])
WITHOUT(fmi3GetIntervalFraction, const Reference at[], size_t n, uint64_t counters[], uint64_t resolutions[],
    int qualifiers[])
WITHOUT(fmi3GetShiftDecimal, const Reference at[], size_t n, double shifts[])
WITHOUT(fmi3GetShiftFraction, const Reference at[], size_t n, uint64_t counters[], uint64_t resolutions[])
WITHOUT(fmi3SetIntervalDecimal, const Reference at[], size_t n, const double intervals[])
WITHOUT(fmi3SetIntervalFraction, const Reference at[], size_t n, const uint64_t counters[], const uint64_t
    resolutions[])
WITHOUT(fmi3SetShiftDecimal, const Reference at[], size_t n, const double shifts[])
WITHOUT(fmi3SetShiftFraction, const Reference at[], size_t n, const uint64_t counters[], const uint64_t
    resolutions[])
WITHOUT(fmi3UpdateDiscreteStates, bool *again, bool *terminate, bool *nominals, bool *changed, bool *defined,
    double *next)
WITHOUT(fmi3CompletedIntegratorStep, bool done, bool *event, bool *terminate)
WITHOUT(fmi3SetTime, double t)
WITHOUT(fmi3SetContinuousStates, const double states[], size_t n)
WITHOUT(fmi3GetContinuousStateDerivatives, double values[], size_t n)
WITHOUT(fmi3GetEventIndicators, double values[], size_t n)
WITHOUT(fmi3GetContinuousStates, double values[], size_t n)
WITHOUT(fmi3GetNominalsOfContinuousStates, double values[], size_t n)
WITHOUT(fmi3GetNumberOfEventIndicators, size_t *n)
WITHOUT(fmi3GetNumberOfContinuousStates, size_t *n)
WITHOUT(fmi3GetOutputDerivatives, const Reference at[], size_t n, const int32_t orders[], double values[],
    size_t n_values)
WITHOUT(fmi3ActivateModelPartition, Reference clock, double t)

#define WITHOUT_ARGUMENT(name) EXPORT Status name(Instance c) { return ERROR; }
WITHOUT_ARGUMENT(fmi3EnterConfigurationMode)
WITHOUT_ARGUMENT(fmi3ExitConfigurationMode)
WITHOUT_ARGUMENT(fmi3EnterEventMode)
WITHOUT_ARGUMENT(fmi3EnterStepMode)
WITHOUT_ARGUMENT(fmi3EnterContinuousTimeMode)
WITHOUT_ARGUMENT(fmi3EvaluateDiscreteStates)
