
void ${law}_init(${law} *law, const double inputs[]${recalls})
{
    const double time = 0;
${own}    begin_of(inputs, own, law->states);
    outputs_of(law->states, inputs, design, &time, law->outputs);
    law->samples = 0;
}

void ${law}_step(${law} *law, const double inputs[])
{
    const double period = ${step}, time = (double)(law->samples + 1) * period;
    double next[${states}];
    int i;
    sample_0_of(law->states, inputs, design, &time, &period, next);
    for (i = 0; i < ${states}; i++)
        law->states[i] = next[i];
    outputs_of(law->states, inputs, design, &time, law->outputs);
    law->samples++;
}

void ${law}_table(const ${law} *law, double from, double to,
    double *position, double *offset, double *coefficient)
{
    *position = from;
    *offset = 0;
    *coefficient = law->outputs[${upper}_CORRECTION] / (to - from);
}
