/* What FMI 2.0 and 3.0 have in common: one model with real variables. */
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
#if defined(__GNUC__) /* most arguments of the standard concern other kinds of models */
#pragma GCC diagnostic ignored "-Wunused-parameter"
#endif

typedef void *Instance;
typedef void *State;
typedef uint32_t Reference;
typedef const char *String;
typedef enum { OK, WARNING, DISCARD, ERROR, FATAL } Status;

/* A function that the standard asks for and that this kind of model does not have. */
#define WITHOUT(name, ...) \
    EXPORT Status name(Instance c, __VA_ARGS__) { return ERROR; }

static Instance instance(String token)
{
    Model *model = token != NULL && strcmp(token, MODEL_TOKEN) == 0 ? malloc(sizeof(Model)) : NULL;
    if (model != NULL) {
        model_start(model);
    }
    return model;
}

static Status reset(Instance c)
{
    model_start((Model *)c);
    return OK;
}

static Status begin(Instance c, double start)
{
    ((Model *)c)->values[0] = start;
    return OK;
}

static Status get_values(Instance c, const Reference at[], size_t n, double values[])
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

static Status set_values(Instance c, const Reference at[], size_t n, const double values[])
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

static Status do_step(Instance c, double t, double step)
{
    Model *model = c;
    if (!(step > 0.0)) {
        return ERROR;
    }
    model_step(model, step);
    model->values[0] = t + step;
    return OK;
}
