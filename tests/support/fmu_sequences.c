/* Random sequences of legal and illegal calls of an FMU: none may crash, and each must be answered as a model of the
 * standard's state machine, kept here, says. Built with the sources of an exported FMU:
 *   cc -DFMI=2 -I FMU/sources tests/support/fmu_sequences.c -o run -fsanitize=address,undefined && ./run 100000 1
 * The arguments are the number of sequences and the seed. */
#include "all.c"

#include <math.h>

#if FMI == 2
typedef fmi2Component instance_t;
typedef fmi2FMUstate state_t;
typedef fmi2Byte byte_t;
typedef int truth_t;
#define DO(name) fmi2##name
#define SIZE(n)
#define STATE_OF(name) fmi2##name##FMUstate
#define GET_REAL fmi2GetReal
#define SET_REAL fmi2SetReal
#define GET_WHOLE fmi2GetInteger
#define SET_WHOLE fmi2SetInteger
#define DESERIALIZE fmi2DeSerializeFMUstate
#define STATE_SIZE fmi2SerializedFMUstateSize
#else
typedef fmi3Instance instance_t;
typedef fmi3FMUState state_t;
typedef fmi3Byte byte_t;
typedef bool truth_t;
#define DO(name) fmi3##name
#define SIZE(n) , (n)
#define STATE_OF(name) fmi3##name##FMUState
#define GET_REAL fmi3GetFloat64
#define SET_REAL fmi3SetFloat64
#define GET_WHOLE fmi3GetInt32
#define SET_WHOLE fmi3SetInt32
#define DESERIALIZE fmi3DeserializeFMUState
#define STATE_SIZE fmi3SerializedFMUStateSize
#endif

enum { LIVE = 3, KEPT = 4, CALLS = 60, MOST = 6 };

typedef struct live {
    instance_t c;
    int mode;     /* what the standard's state machine says, kept apart from the FMU's own */
    double time;
    int has_stop;
    double stop;
    double low, high; /* limits of the output, which are parameters */
} live;

typedef struct kept {
    state_t state;
    live at; /* mode and time when it was taken */
} kept;

static uint64_t seed;
static unsigned long calls, refused, discarded, steps, messages, forged;

static uint32_t draw(uint32_t below)
{
    seed ^= seed << 13;
    seed ^= seed >> 7;
    seed ^= seed << 17;
    return (uint32_t)((seed >> 16) % below);
}

static void expect(int answer, int wanted, const char *call)
{
    ++calls;
    refused += answer == FMU_ERROR;
    discarded += answer == FMU_DISCARD;
    if (answer != wanted) {
        fprintf(stderr, "%s answered %d where %d was expected, after %lu calls\n", call, answer, wanted, calls);
        abort();
    }
}

/* What an instance remembers, to see that a refused call changes none of it. */
static int same(const fmu_image *a, const fmu_image *b)
{
    return !memcmp(a, b, FMU_IMAGE_BYTES);
}

static double some_real(void)
{
    static const double odd[] = {0.0, -0.0, 1e-320, 1e16, -1e200, 1e308, INFINITY, -INFINITY, NAN};
    if (draw(6) == 0) {
        return odd[draw((uint32_t)(sizeof odd / sizeof *odd))];
    }
    if (draw(20) == 0) { /* any pattern */
        uint64_t bits = ((uint64_t)draw(0xffffffffu) << 32) | draw(0xffffffffu);
        double x;
        memcpy(&x, &bits, sizeof x);
        return x;
    }
    return ((double)draw(2000001) - 1e6) * 1e-5;
}

#if FMI == 2
static void logged(void *environment, fmi2String name, fmi2Status status, fmi2String category, fmi2String message, ...)
{
    (void)environment, (void)name, (void)status;
    messages += strlen(category) + strlen(message) > 0;
}

static instance_t created(const char *token, int good)
{
    static const fmi2CallbackFunctions own = {logged, calloc, free, NULL, NULL}, none = {NULL, NULL, NULL, NULL, NULL};
    return fmi2Instantiate(good || draw(2) ? "one" : NULL, fmi2CoSimulation, token, NULL, draw(2) ? &own : &none, 0,
                           (int)draw(2));
}
#else
static void logged(void *environment, fmi3Status status, fmi3String category, fmi3String message)
{
    (void)environment, (void)status;
    messages += strlen(category) + strlen(message) > 0;
}

static instance_t created(const char *token, int good)
{
    if (!good && draw(4) == 0) {
        return fmi3InstantiateModelExchange("one", FMU_TOKEN, NULL, false, true, NULL, logged);
    }
    return fmi3InstantiateCoSimulation(good || draw(2) ? "one" : NULL, token, NULL, false, draw(2) != 0,
                                       false, draw(2) != 0, NULL, 0, NULL, draw(2) ? logged : NULL, NULL);
}
#endif

/* Parameters that there are: scale, offset, lowest and highest output, fade, in this order. */
#ifdef OUTPUT_LOW
static void exported(live *one)
{
    one->low = OUTPUT_LOW;
    one->high = OUTPUT_HIGH;
}

static int can_be(const fmu_variable *v, double x)
{
    const int limited = x >= OUTPUT_LOW && x <= OUTPUT_HIGH;
    const int allowed[] = {x > 0, 1, limited, limited, x > 0 && x <= 1};
    return fabs(x) <= 1e100 && allowed[v->place - FMU_FIRST];
}

static void takes(live *one, const fmu_variable *v, double x)
{
    one->low = v->place == FMU_FIRST + 2 ? x : one->low;
    one->high = v->place == FMU_FIRST + 3 ? x : one->high;
}
#else
static void exported(live *one)
{
    (void)one;
}

static int can_be(const fmu_variable *v, double x)
{
    (void)v, (void)x;
    return 1;
}

static void takes(live *one, const fmu_variable *v, double x)
{
    (void)one, (void)v, (void)x;
}
#endif

static int settable(uint32_t vr)
{
    return fmu_variables[vr].role == FMU_INPUT || fmu_variables[vr].role == FMU_PARAMETER;
}

static void do_create(live *one)
{
    if (draw(5) == 0 && created(draw(2) ? "{wrong}" : NULL, 0)) {
        fprintf(stderr, "a wrong token was taken\n");
        abort();
    }
    memset(one, 0, sizeof *one);
    exported(one);
    one->c = created(FMU_TOKEN, 1);
    if (!one->c) {
        abort();
    }
}

/* References: mostly of one type, sometimes wrong; says whether a call with them is right. */
static int references(uint32_t *vr, size_t n, int type, int writing, size_t *values)
{
    int right = 1;
    *values = 0;
    for (size_t i = 0; i < n; ++i) {
        vr[i] = draw(12) ? draw(FMU_VARIABLES) : draw(0xffffffffu);
        for (int k = 0; k < 200 && draw(30) && (vr[i] >= FMU_VARIABLES || fmu_variables[vr[i]].type != type ||
                                                (writing && !settable(vr[i]))); ++k) {
            vr[i] = draw(FMU_VARIABLES);
        }
        const int known = vr[i] < FMU_VARIABLES && fmu_variables[vr[i]].type == type;
        right = right && known && (!writing || settable(vr[i]));
        *values += known ? fmu_variables[vr[i]].length : 1;
    }
    return right;
}

static void do_access(live *one)
{
    static double real[MOST * 4096];
    static int32_t whole[MOST * 64];
    static truth_t truth[MOST * 64];
    uint32_t vr[MOST];
    static const int types[] = {FMU_REAL, FMU_WHOLE, FMU_TRUTH, FMU_TEXT};
    const int type = types[draw(4)], writing = (int)draw(2), missing = draw(15) == 0;
    const size_t n = draw(MOST + 1);
    size_t values;
    int right = references(vr, n, type, writing, &values) && (!missing || !n);
    right = right && !(writing && one->mode == FMU_TERMINATED);
    uint32_t *at = missing ? NULL : vr;
#if FMI == 3
    if (draw(15) == 0) {
        ++values;
        right = 0;
    }
#endif
    for (size_t i = 0; i < values && i < sizeof real / sizeof *real; ++i) {
        real[i] = writing ? some_real() : 0;
    }
    const int taken = right && writing && type == FMU_REAL; /* a value each, as far as they can be */
    for (size_t i = 0; i < n && taken; ++i) {
        right = right && (fmu_variables[vr[i]].role != FMU_PARAMETER || can_be(&fmu_variables[vr[i]], real[i]));
    }
    for (size_t i = 0; i < n && taken && right; ++i) {
        takes(one, &fmu_variables[vr[i]], real[i]);
    }
    for (size_t i = 0; i < values && i < MOST * 64u; ++i) {
        truth[i] = (truth_t)draw(2);
    }
    int answer;
    if (type == FMU_REAL) {
        answer = writing ? SET_REAL(one->c, at, n, real SIZE(values)) : GET_REAL(one->c, at, n, real SIZE(values));
    } else if (type == FMU_WHOLE) {
        answer = writing ? SET_WHOLE(one->c, at, n, whole SIZE(values)) : GET_WHOLE(one->c, at, n, whole SIZE(values));
    } else if (type == FMU_TRUTH) {
        answer = writing ? DO(SetBoolean)(one->c, at, n, truth SIZE(values)) : DO(GetBoolean)(one->c, at, n, truth SIZE(values));
    } else {
        static const char *text[MOST + 1];
        answer = writing ? DO(SetString)(one->c, at, n, text SIZE(values)) : DO(GetString)(one->c, at, n, text SIZE(values));
    }
    expect(answer, right ? FMU_OK : FMU_ERROR, "get or set");
}

static void check_outputs(live *one)
{
    for (uint32_t vr = 0; vr < FMU_VARIABLES; ++vr) {
        double value = 0;
        if (fmu_variables[vr].type == FMU_REAL && fmu_variables[vr].role == FMU_OUTPUT) {
            expect(GET_REAL(one->c, &vr, 1, &value SIZE(1)), FMU_OK, "get of an output");
            if (!fmu_finite(value)) {
                fprintf(stderr, "output %u is not finite\n", (unsigned)vr);
                abort();
            }
#ifdef OUTPUT_LOW
            if (value < OUTPUT_LOW || value > OUTPUT_HIGH) {
                fprintf(stderr, "output %u = %g leaves its range\n", (unsigned)vr, value);
                abort();
            }
#endif
        }
    }
}

static void do_step(live *one)
{
    const double period = FMU_PERIOD > 0 ? FMU_PERIOD : 0.01;
    double t = one->time, h = period * (1 + draw(3));
    int wanted = one->mode == FMU_STEPPING ? FMU_OK : FMU_ERROR, missing = 0;
    if (draw(10) == 0) {
        t = some_real();
    }
    if (draw(10) == 0) {
        h = draw(2) ? some_real() : period * 1.37;
    }
#if FMI == 3
    missing = draw(20) == 0;
#endif
    if (wanted == FMU_OK) {
        const double apart = fabs(t - one->time), rounding = 4 * DBL_EPSILON * fabs(t);
        if (missing || !isfinite(t) || !isfinite(h) || !(h > 0) || !isfinite(t + h) ||
            rounding > 0.25 * h || apart > 1e-6 * h + rounding || (one->has_stop && t + h > one->stop + 0.5 * h) ||
            one->low > one->high) {
            wanted = FMU_ERROR;
        } else if (FMU_PERIOD > 0 && (h / period > 1e6 || round(h / period) < 1 ||
                                      fabs(h / period - round(h / period)) > 1e-6 * round(h / period))) {
            wanted = FMU_DISCARD;
        }
    }
    fmu_image before, after;
    const int looked = wanted != FMU_OK && draw(4) == 0;
    if (looked) {
        fmu_take((fmu_instance *)one->c, &before);
    }
#if FMI == 2
    (void)missing;
    const int answer = fmi2DoStep(one->c, t, h, 0);
#else
    bool a = true, b = true, e = true;
    double last = 0;
    const int answer = fmi3DoStep(one->c, t, h, false, &a, missing ? NULL : &b, &e, &last);
#endif
    expect(answer, wanted, "DoStep");
    if (looked) {
        fmu_take((fmu_instance *)one->c, &after);
        expect(same(&before, &after) ? FMU_OK : FMU_ERROR, FMU_OK, "a refused step changed something, and");
    }
    if (answer == FMU_OK) {
        one->time = t + h;
        ++steps;
        check_outputs(one);
    }
}

static void start_experiment(live *one)
{
    const double start = draw(8) ? (double)draw(3) : some_real();
    const int has_stop = draw(3) == 0;
    const double stop = draw(8) ? start + draw(20) : some_real();
    const int times = isfinite(start) && (!has_stop || (isfinite(stop) && stop >= start));
    const int wanted = one->mode == FMU_INSTANTIATED && times ? FMU_OK : FMU_ERROR;
#if FMI == 2
    expect(fmi2SetupExperiment(one->c, (int)draw(2), some_real(), start, has_stop, stop), wanted, "SetupExperiment");
#else
    expect(fmi3EnterInitializationMode(one->c, draw(2) != 0, some_real(), start, has_stop, stop), wanted, "Enter");
    one->mode = wanted == FMU_OK ? FMU_INITIALIZING : one->mode;
#endif
    if (wanted == FMU_OK) {
        one->time = start;
        one->has_stop = has_stop;
        one->stop = stop;
    }
}

static void do_reset(live *one)
{
    const instance_t c = one->c;
    expect(DO(Reset)(c), FMU_OK, "Reset");
    memset(one, 0, sizeof *one);
    exported(one);
    one->c = c;
}

static void do_mode(live *one)
{
    const uint32_t which = draw(8);
    const int mode = one->mode;
    if (which == 0 && draw(6) == 0) {
        do_reset(one);
    } else if (which == 1) {
        start_experiment(one);
    } else if (which == 2 && draw(6) == 0) {
        expect(DO(Terminate)(one->c), mode == FMU_STEPPING ? FMU_OK : FMU_ERROR, "Terminate");
        one->mode = mode == FMU_STEPPING ? FMU_TERMINATED : mode;
    } else if (which < 6) {
#if FMI == 2
        expect(fmi2EnterInitializationMode(one->c), mode == FMU_INSTANTIATED ? FMU_OK : FMU_ERROR, "Enter");
        one->mode = mode == FMU_INSTANTIATED ? FMU_INITIALIZING : mode;
#else
        start_experiment(one);
#endif
    } else {
        const int ready = mode == FMU_INITIALIZING && !(one->low > one->high);
        expect(DO(ExitInitializationMode)(one->c), ready ? FMU_OK : FMU_ERROR, "Exit");
        one->mode = ready ? FMU_STEPPING : mode;
    }
}

static void go_back(live *one, const kept *to)
{
    const instance_t c = one->c;
    *one = to->at;
    one->c = c;
}

static void do_state(live *one, kept *states)
{
    kept *slot = &states[draw(KEPT)];
    size_t size = 0;
    switch (draw(6)) {
    case 0:
        expect(STATE_OF(Get)(one->c, &slot->state), FMU_OK, "GetFMUState");
        slot->at = *one;
        break;
    case 1:
        expect(STATE_OF(Set)(one->c, slot->state), slot->state ? FMU_OK : FMU_ERROR, "SetFMUState");
        if (slot->state) {
            go_back(one, slot);
        }
        break;
    case 2:
        expect(STATE_OF(Free)(one->c, &slot->state), FMU_OK, "FreeFMUState");
        break;
    case 3:
        expect(STATE_OF(Get)(one->c, NULL), FMU_ERROR, "GetFMUState");
        expect(STATE_SIZE(one->c, NULL, &size), FMU_ERROR, "SerializedFMUStateSize");
        break;
    default:
        if (slot->state) {
            expect(STATE_SIZE(one->c, slot->state, &size), FMU_OK, "SerializedFMUStateSize");
            byte_t *bytes = (byte_t *)malloc(size);
            expect(STATE_OF(Serialize)(one->c, slot->state, bytes, size - 1), FMU_ERROR, "SerializeFMUState");
            expect(STATE_OF(Serialize)(one->c, slot->state, bytes, size), FMU_OK, "SerializeFMUState");
            const int hurt = (int)draw(2);
            state_t again = NULL;
            for (uint32_t k = 0; hurt && k < 1 + draw(3); ++k) {
                bytes[draw((uint32_t)size)] ^= (byte_t)(1u << draw(7));
            }
            byte_t *whole = (byte_t *)malloc(size); /* two flips may cancel: what is undamaged is told by comparing */
            memcpy(whole, slot->state, size);
            const int undamaged = !memcmp(whole, bytes, size);
            expect(DESERIALIZE(one->c, bytes, size - draw(2) * (size - 1), NULL), FMU_ERROR, "DeserializeFMUState");
            expect(DESERIALIZE(one->c, bytes, size, &again), undamaged ? FMU_OK : FMU_ERROR, "DeserializeFMUState");
            if (undamaged) {
                expect(STATE_OF(Set)(one->c, again), FMU_OK, "SetFMUState");
                go_back(one, slot);
                expect(STATE_OF(Free)(one->c, &again), FMU_OK, "FreeFMUState");
            }
            free(whole);
            free(bytes);
        }
    }
}

/* An image whose checksum is right and whose content is not: it is taken or refused, and a refusal changes nothing. */
static void do_forge(live *one)
{
    fmu_image image, before, after;
    fmu_take((fmu_instance *)one->c, &image);
    before = image;
    unsigned char *bytes = (unsigned char *)&image;
    for (uint32_t k = 0; k < 1 + draw(4); ++k) {
        bytes[draw((uint32_t)FMU_IMAGE_BYTES)] ^= (unsigned char)(1u << draw(8));
    }
    if (draw(2)) { /* the core's own checksum too */
        image.unit[FMU_UNIT_WORDS - 1] = dehyst_image_sum(image.unit, FMU_UNIT_WORDS - 1);
    }
    image.sum = fmu_sum(&image, offsetof(fmu_image, sum));
    state_t state = NULL;
    const int taken = DESERIALIZE(one->c, (const byte_t *)&image, FMU_IMAGE_BYTES, &state) == 0;
    if (taken && STATE_OF(Set)(one->c, state) == 0) {
        ++forged;
        do_reset(one);
    } else {
        fmu_take((fmu_instance *)one->c, &after);
        expect(same(&before, &after) ? FMU_OK : FMU_ERROR, FMU_OK, "a refused state changed something, and");
    }
    expect(STATE_OF(Free)(one->c, &state), FMU_OK, "FreeFMUState");
}

/* Calls without an instance, calls of what this FMU does not have, and messages. */
static void do_others(live *one)
{
    static const char *const names[] = {"logAll", "logStatusWarning", "nothing"};
    const uint32_t n = draw(4);
    const int named = n == 0 || draw(8) != 0;
    double x = 0;
    expect(DO(SetDebugLogging)(one->c, draw(2) != 0, n, named ? names : NULL), named && n < 3 ? FMU_OK : FMU_ERROR,
           "SetDebugLogging");
    expect(DO(Reset)(NULL), FMU_ERROR, "Reset");
    expect(DO(Terminate)(NULL), FMU_ERROR, "Terminate");
    expect(DO(ExitInitializationMode)(NULL), FMU_ERROR, "ExitInitializationMode");
    expect(GET_REAL(NULL, NULL, 0, NULL SIZE(0)), FMU_ERROR, "get");
    expect(STATE_OF(Set)(NULL, NULL), FMU_ERROR, "SetFMUState");
    expect(DO(GetDirectionalDerivative)(one->c, NULL, 0, NULL, 0, NULL SIZE(0), NULL SIZE(0)), FMU_ERROR, "derivative");
#if FMI == 2
    fmi2Boolean b = 1;
    fmi2Status s;
    expect(fmi2DoStep(NULL, 0, 1, 0), FMU_ERROR, "DoStep");
    expect(fmi2CancelStep(one->c), FMU_ERROR, "CancelStep");
    expect(fmi2GetRealStatus(one->c, fmi2LastSuccessfulTime, &x), FMU_OK, "GetRealStatus");
    expect(fmi2GetBooleanStatus(one->c, fmi2Terminated, &b), FMU_OK, "GetBooleanStatus");
    expect(fmi2GetStatus(one->c, fmi2DoStepStatus, &s), FMU_DISCARD, "GetStatus");
    expect(fmi2GetStringStatus(one->c, fmi2PendingStatus, NULL), FMU_ERROR, "GetStringStatus");
    expect(fmi2SetRealInputDerivatives(one->c, NULL, 0, NULL, NULL), FMU_ERROR, "SetRealInputDerivatives");
#else
    size_t size = 0;
    expect(fmi3DoStep(NULL, 0, 1, false, NULL, NULL, NULL, NULL), FMU_ERROR, "DoStep");
    expect(fmi3EnterEventMode(one->c), FMU_ERROR, "EnterEventMode");
    expect(fmi3EnterStepMode(one->c), FMU_ERROR, "EnterStepMode");
    expect(fmi3EnterConfigurationMode(one->c), FMU_ERROR, "EnterConfigurationMode");
    expect(fmi3SetTime(one->c, some_real()), FMU_ERROR, "SetTime");
    expect(fmi3GetNumberOfContinuousStates(one->c, &size), FMU_ERROR, "GetNumberOfContinuousStates");
    expect(fmi3GetClock(one->c, NULL, 1, NULL), FMU_ERROR, "GetClock");
    expect(fmi3GetBinary(one->c, NULL, 0, NULL, NULL, 0), one->c ? FMU_OK : FMU_ERROR, "GetBinary");
    expect(fmi3GetUInt64(one->c, NULL, 2, NULL, 2), FMU_ERROR, "GetUInt64");
    (void)x;
#endif
}

static void sequence(void)
{
    live one[LIVE];
    kept states[KEPT];
    memset(states, 0, sizeof states);
    for (int i = 0; i < LIVE; ++i) {
        do_create(&one[i]);
    }
    for (int k = 0; k < CALLS; ++k) {
        live *here = &one[draw(LIVE)];
        switch (draw(20)) {
        case 0: case 1: case 2: case 3: do_mode(here); break;
        case 4: case 5: case 6: case 7: case 8: case 9: case 10: case 11: do_step(here); break;
        case 12: case 13: case 14: case 15: case 16: do_access(here); break;
        case 17: do_state(here, states); break;
        case 18: draw(4) ? do_state(here, states) : do_forge(here); break;
        default: do_others(here);
        }
    }
    for (int i = 0; i < KEPT; ++i) {
        expect(STATE_OF(Free)(one[0].c, &states[i].state), FMU_OK, "FreeFMUState");
    }
    for (int i = 0; i < LIVE; ++i) {
        DO(FreeInstance)(one[i].c);
    }
    DO(FreeInstance)(NULL);
}

int main(int argc, char **argv)
{
    const unsigned long sequences = argc > 1 ? strtoul(argv[1], NULL, 10) : 1000;
    seed = 88172645463325252u ^ ((argc > 2 ? strtoull(argv[2], NULL, 10) : 1u) * 0x9e3779b97f4a7c15u);
    for (unsigned long k = 0; k < sequences; ++k) {
        sequence();
    }
    printf("%lu sequences, %lu calls, %lu refused, %lu discarded, %lu steps, %lu messages, %lu forged\n", sequences, calls, refused,
           discarded, steps, messages, forged);
    return 0;
}
