/* Runs the law through its test vectors: ends with 0 where they are met.
${origin} */
#include <math.h>
#include <stdio.h>
#include <string.h>
#include "${law}.h"

enum { INPUTS = ${input_count}, OUTPUTS = ${output_count}, SAMPLES = ${count} };

/* ${input_names} */
static const double inputs[SAMPLES][INPUTS] = {
${given}};

/* ${output_names} */
static const double outputs[SAMPLES][OUTPUTS] = {
${taken}};

/* Largest that each output may be off. */
static const double allowed[OUTPUTS] = {${allowed}};

int main(void)
{
    static ${law} one;
    ${law}_inputs now;
    ${law}_real given[INPUTS], said[OUTPUTS];
    double largest = 0.0;
    int i, k, wrong = 0;
    for (k = 0; k < SAMPLES; k++) {
        for (i = 0; i < INPUTS; i++)
            given[i] = (${law}_real)inputs[k][i];
        memcpy(&now, given, sizeof now);
        if (k == 0)
            ${law}_init(&one, &now${nothing});
        else
            ${law}_step(&one, &now);
        memcpy(said, &one.outputs, sizeof said);
        for (i = 0; i < OUTPUTS; i++) {
            const double off = fabs((double)said[i] - outputs[k][i]);
            if (!(off <= allowed[i]) && wrong++ < 10)
                printf("sample %d, output %d: %.17g, not %.17g\n", k, i, (double)said[i], outputs[k][i]);
        }
        largest = fmax(largest, fabs((double)one.outputs.correction - outputs[k][${correction}]));
    }
    printf("largest difference of the correction: %g m\n", largest);
    return wrong != 0;
}
