/* Long calls can be stopped: about every millisecond of work they ask their host whether to go on. A stopped call returns
 * at once; what it wrote is of no use, its memory is that of some sample on the way. */
#ifndef ENGINE_PATIENCE_H
#define ENGINE_PATIENCE_H

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

enum { ENGINE_BETWEEN = 1 << 20 }; /* units of work between two questions, of about a nanosecond each */

/* Who is asked, from any thread: 1 to stop, 0 to go on. A null pointer, the default: nobody. */
void engine_ask(int (*stop)(void));
int engine_asked(void);

/* To be called before each part of the work; `left` begins as ENGINE_BETWEEN. */
static inline int engine_stops(int64_t *left, int64_t work)
{
    if ((*left -= work) > 0) {
        return 0;
    }
    *left = ENGINE_BETWEEN;
    return engine_asked();
}

/* Where loops of cheap samples ask next: for (t = 0; (end = engine_until(t, samples, work)) > t;) for (; t < end; ++t) ... */
static inline int64_t engine_until(int64_t from, int64_t samples, int64_t work)
{
    const int64_t part = work < ENGINE_BETWEEN ? ENGINE_BETWEEN / work : 1;
    return from > 0 && engine_asked() ? from : samples - from < part ? samples : from + part;
}

#ifdef __cplusplus
}
#endif

#endif
