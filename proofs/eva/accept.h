/* The guard as the analyser understands it: it loses an input whose bits are read. That both are one function is what
 * the proof "guard" shows, for every pattern of bits. */
#include "dehyst.h"
#define dehyst_accept(x) ((x) == (x) && (x) <= DEHYST_INPUT_LIMIT && (x) >= -DEHYST_INPUT_LIMIT)
