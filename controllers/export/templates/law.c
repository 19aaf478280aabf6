/* ${description}.
${origin} */
${includes}#include "${law}.h"

/* The design. Constants belong together: change them by a new export, not here. */
${constants}

${helpers}${functions}${init}
{
${beginning}}

${step}
{
    ${law}_state next;
${stepping}}

void ${law}_table(const ${law} *law, ${law}_real from, ${law}_real to,
    ${law}_real *position, ${law}_real *offset, ${law}_real *coefficient)
{
    const ${law}_real apart = to - from;
    const bool even = (apart > ${zero}) || (apart < ${zero});
    *position = from;
    *offset = even ? ${zero} : law->outputs.correction;
    *coefficient = even ? (law->outputs.correction / apart) : ${zero};
}
