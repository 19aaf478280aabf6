/* ${description}.
${origin}
   README.md beside it says how to use it. */
#ifndef ${upper}_H
#define ${upper}_H

typedef ${real} ${law}_real;

/* What the law is given, in SI units; a reading that is missing is NaN. */
typedef struct {
${inputs}
} ${law}_inputs;

/* What the law says, in SI units. */
typedef struct {
${outputs}
} ${law}_outputs;

/* What the law remembers from one sample to the next. */
typedef struct {
${states}
} ${law}_state;
${recall}
/* One law at work. */
typedef struct {
    ${law}_state state;
    ${law}_outputs outputs;
${more}} ${law};

/* Begins with the first inputs.${restart} */
${init};
/* One sample, each ${period} s. */
${step};
/* The correction at a place P along the link is offset + coefficient (P - position), all in m; `from` is the
   place that the link is fixed at, `to` the one that the tool is fixed at. The growth is taken as even along
   the link; where the two places are one, all of it is the offset. */
void ${law}_table(const ${law} *law, ${law}_real from, ${law}_real to,
    ${law}_real *position, ${law}_real *offset, ${law}_real *coefficient);

#endif
