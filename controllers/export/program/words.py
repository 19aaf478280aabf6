"""FreeNames that a law's variables may not have, in C or in Structured Text, in small letters."""

_C = """auto break case char const continue default do double else enum extern float for goto if inline int
long register restrict return short signed sizeof static struct switch typedef union unsigned void
volatile while bool true false main nan infinity exp log sqrt fabs sin cos floor pow erf errno
signbit y0 y1 j0 j1 yn jn gamma isnan"""

_ST = """abs acos action add and any any_bit any_int any_num any_real array asin at atan bool by byte case
concat configuration constant cos ctd ctu ctud date delete dint div do dt dword else elsif
end_action end_array end_case end_configuration end_for end_function end_function_block end_if
end_program end_repeat end_resource end_step end_struct end_transition end_type end_var end_while en
eno eq exit exp expt f_edge f_trig false find for from function function_block ge gt if in
initial_step insert int interval le left len limit lint ln log lreal lt lword max mid min mod move
mul mux ne non_retain not of off on or priority program r r_edge r_trig real read_only read_write
repeat replace resource retain return right rol ror rs s sel shl shr sin single sint sqrt sr step
string struct sub tan task then time tod to tof ton tp transition true trunc type udint uint ulint
until usint var var_access var_config var_external var_global var_in_out var_input var_output
var_temp while with word wstring xor day char date_and_time time_of_day sema rtc integral derivative
pid ramp hysteresis val value_of size_of adr"""

RESERVED = frozenset(f"{_C} {_ST} i j k side".split())
