/* FMI 2.0 for co-simulation. Declarations follow the standard. */
#include "fmi.h"

typedef int Boolean;

EXPORT const char *fmi2GetTypesPlatform(void) { return "default"; }

EXPORT const char *fmi2GetVersion(void) { return "2.0"; }

EXPORT Status fmi2SetDebugLogging(Instance c, Boolean on, size_t n, const String names[]) { return OK; }

EXPORT Instance fmi2Instantiate(String name, int kind, String token, String resources, const void *callbacks,
    Boolean visible, Boolean logging)
{
    return kind == 1 ? instance(token) : NULL; /* 1: co-simulation */
}

EXPORT void fmi2FreeInstance(Instance c) { free(c); }

EXPORT Status fmi2SetupExperiment(Instance c, Boolean has_tolerance, double tolerance, double start,
    Boolean has_stop, double stop)
{
    return begin(c, start);
}

EXPORT Status fmi2EnterInitializationMode(Instance c) { return OK; }

EXPORT Status fmi2ExitInitializationMode(Instance c) { return OK; }

EXPORT Status fmi2Terminate(Instance c) { return OK; }

EXPORT Status fmi2Reset(Instance c) { return reset(c); }

EXPORT Status fmi2GetReal(Instance c, const Reference at[], size_t n, double values[])
{
    return get_values(c, at, n, values);
}

EXPORT Status fmi2SetReal(Instance c, const Reference at[], size_t n, const double values[])
{
    return set_values(c, at, n, values);
}

EXPORT Status fmi2DoStep(Instance c, double t, double step, Boolean no_return) { return do_step(c, t, step); }

/* What follows belongs to other kinds of models; the standard asks that it exists. */
#define NO_VARIABLES(name, type) \
    EXPORT Status fmi2Get##name(Instance c, const Reference at[], size_t n, type values[]) \
    { \
        return n == 0 ? OK : ERROR; \
    } \
    EXPORT Status fmi2Set##name(Instance c, const Reference at[], size_t n, const type values[]) \
    { \
        return n == 0 ? OK : ERROR; \
    }
#define NO_STATUS(name, type) \
    EXPORT Status fmi2Get##name(Instance c, int kind, type *value) { return DISCARD; }

NO_VARIABLES(Integer, int)
NO_VARIABLES(Boolean, Boolean)
NO_VARIABLES(String, String)
NO_STATUS(Status, Status)
NO_STATUS(RealStatus, double)
NO_STATUS(IntegerStatus, int)
NO_STATUS(BooleanStatus, Boolean)
NO_STATUS(StringStatus, String)
WITHOUT(fmi2GetFMUstate, State *state)
WITHOUT(fmi2SetFMUstate, State state)
WITHOUT(fmi2FreeFMUstate, State *state)
WITHOUT(fmi2SerializedFMUstateSize, State state, size_t *size)
WITHOUT(fmi2SerializeFMUstate, State state, char data[], size_t size)
WITHOUT(fmi2DeSerializeFMUstate, const char data[], size_t size, State *state)
WITHOUT(fmi2GetDirectionalDerivative, const Reference unknowns[], size_t n_unknowns, const Reference knowns[],
    size_t n_knowns, const double seed[], double sensitivity[])
WITHOUT(fmi2SetRealInputDerivatives, const Reference at[], size_t n, const int orders[], const double values[])
WITHOUT(fmi2GetRealOutputDerivatives, const Reference at[], size_t n, const int orders[], double values[])

EXPORT Status fmi2CancelStep(Instance c) { return ERROR; }
