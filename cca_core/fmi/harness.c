/* Runs the recorded inputs and compares the outputs bit for bit: harness cases.txt */
#include <stdio.h>
#include <string.h>
#include <time.h>

#include "model.h"

static Model model;

int main(int argc, char *argv[])
{
    FILE *cases = argc > 1 ? fopen(argv[1], "r") : NULL;
    double in[7], expected, longest = 0.0;
    long n = 0, equal = 0;
    if (cases == NULL) {
        fprintf(stderr, "usage: harness cases.txt\n");
        return 2;
    }
    model_start(&model);
    while (fscanf(cases, "%la %la %la %la %la %la %la %la", &in[0], &in[1], &in[2], &in[3], &in[4], &in[5], &in[6],
               &expected) == 8) {
        memcpy(&model.values[1], in, 6 * sizeof(double));
        clock_t begin = clock();
        model_step(&model, in[6]);
        double took = (double)(clock() - begin) / (double)CLOCKS_PER_SEC;
        longest = took > longest ? took : longest;
        equal += memcmp(&model.values[MODEL_VARIABLES - 1], &expected, sizeof(double)) == 0;
        n++;
    }
    fclose(cases);
    printf("%ld of %ld equal, %lu bytes of state, longest step %.0f us\n", equal, n, (unsigned long)sizeof(Model),
        1e6 * longest);
    return n > 0 && equal == n ? 0 : 1;
}
