#include "patience.h"

#include <stddef.h>

static int (*asked)(void);

void engine_ask(int (*stop)(void)) { asked = stop; }

int engine_asked(void) { return asked != NULL && asked(); }
