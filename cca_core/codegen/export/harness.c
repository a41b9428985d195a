/* Runs recorded inputs and compares the outputs bit for bit: harness cases.txt */
#include <stdio.h>
#include <string.h>
#include <time.h>

#include "model.h"

#define MAX_SEGMENTS 20000

static Model model;
static double breaks[MAX_SEGMENTS + 1], powers[8 * MAX_SEGMENTS];

static bool read_numbers(FILE *file, int count, double *numbers)
{
    for (int i = 0; i < count; i++) {
        if (fscanf(file, "%la", &numbers[i]) != 1) {
            return false;
        }
    }
    return true;
}

static bool follow(FILE *file, bool is_road)
{
    Curve path = {0, breaks, powers};
    double station;
    if (!is_road && (fscanf(file, "%d", &path.segments) != 1 || path.segments < 1 || path.segments > MAX_SEGMENTS)) {
        return false;
    }
    if (!read_numbers(file, 1, &station)) {
        return false;
    }
    if (is_road) {
        model_follow_road(&model, station);
        return true;
    }
    model_follow(&model, &path, NULL, station);
    return read_numbers(file, path.segments + 1, breaks) && read_numbers(file, 8 * path.segments, powers);
}

int main(int argc, char *argv[])
{
    FILE *file = argc > 1 ? fopen(argv[1], "r") : NULL;
    char word[8];
    double in[8];
    clock_t sum = 0, longest = 0;
    long n = 0, equal = 0;
    bool is_good = true;
    if (file == NULL) {
        fprintf(stderr, "usage: harness cases.txt\n");
        return 2;
    }
    model_start(&model);
    while (is_good && fscanf(file, "%7s", word) == 1) {
        if (strcmp(word, "start") == 0) {
            model_start(&model);
        } else if (strcmp(word, "step") != 0) {
            is_good = (strcmp(word, "road") == 0 || strcmp(word, "path") == 0) && follow(file, word[0] == 'r');
        } else if ((is_good = read_numbers(file, 8, in))) {
            memcpy(&model.values[MODEL_X], in, 6 * sizeof(double));
            const clock_t before = clock(), begin = clock();
            model_step(&model, in[6]);
            const clock_t took = clock() - begin;
            sum += took - (begin - before); /* without the time of reading the clock */
            longest = took > longest ? took : longest;
            equal += memcmp(&model.values[MODEL_DELTA], &in[7], sizeof(double)) == 0;
            n++;
        }
    }
    fclose(file);
    printf("%ld of %ld equal%s, %lu bytes of state, a step takes %.2f us, the longest %.0f us\n", equal, n,
        is_good ? "" : " until a line that cannot be read", (unsigned long)sizeof(Model),
        1e6 / CLOCKS_PER_SEC * (double)sum / (double)(n > 0 ? n : 1), 1e6 / CLOCKS_PER_SEC * (double)longest);
    return is_good && n > 0 && equal == n ? 0 : 1;
}
