/* Which kernels run: the best level that both this build and this processor have. */
#include "engine.h"
#include "lanes/kernels.h"

static int chosen = -1;

int engine_best_level(void)
{
#if defined(ENGINE_HAS_AVX512) || defined(ENGINE_HAS_AVX2)
    __builtin_cpu_init();
#ifdef ENGINE_HAS_AVX512
    if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl") &&
        __builtin_cpu_supports("fma")) {
        return ENGINE_AVX512;
    }
#endif
    if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) {
        return ENGINE_AVX2;
    }
#endif
    return ENGINE_PORTABLE;
}

int engine_level(void)
{
    if (chosen < 0) {
        chosen = engine_best_level();
    }
    return chosen;
}

int engine_use_level(int level)
{
    if (level < ENGINE_PORTABLE || level > engine_best_level()) {
        return -1;
    }
    chosen = level;
    return 0;
}

void engine_ramps(int64_t samples, int64_t cells, const double *e, const engine_ramp_table *table, double *out)
{
    engine_kernels_in_use()->ramps(samples, cells, e, table, out);
}

const engine_kernels *engine_kernels_in_use(void)
{
    switch (engine_level()) {
#ifdef ENGINE_HAS_AVX512
    case ENGINE_AVX512:
        return &engine_kernels_avx512;
#endif
#ifdef ENGINE_HAS_AVX2
    case ENGINE_AVX2:
        return &engine_kernels_avx2;
#endif
    default:
        return &engine_kernels_portable;
    }
}
