/* SPDX-License-Identifier: 0BSD
 *
 * What FMI 2.0 and 3.0 have in common: an instance, its modes, its variables, a step, an image of its state, messages.
 * Included once, by all.c, after unit.h, which says what is inside. Every function is static, and nothing is global but
 * constants: instances know nothing of each other, so that each may run in a thread of its own.
 * A call that is refused leaves the instance as it was. */
#ifndef FMU_H
#define FMU_H

#include <float.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

enum { FMU_OK, FMU_WARNING, FMU_DISCARD, FMU_ERROR };                        /* numbers of fmi2Status, fmi3Status */
enum { FMU_INSTANTIATED, FMU_INITIALIZING, FMU_STEPPING, FMU_TERMINATED };   /* modes */
enum { FMU_ALL_MESSAGES = (1 << FMU_WARNING) | (1 << FMU_DISCARD) | (1 << FMU_ERROR) };

#define FMU_MAGIC 0x55464844u   /* "DHFU" where the lowest byte comes first */
#define FMU_MOST_PERIODS 1000000 /* of a fixed period in one communication step */

/* What a state consists of, as it is kept and serialised. Padding is zero. */
typedef struct fmu_image {
    uint32_t magic;
    uint32_t content;              /* checksum of what this FMU is: images of another one are refused */
    int32_t mode;
    int32_t has_stop;
    double time;                   /* where the next step begins, [s] */
    double stop;                   /* if has_stop, [s] */
    double real[FMU_REALS];
    int32_t whole[FMU_WHOLES];
    int32_t truth[FMU_TRUTHS];
    uint32_t unit[FMU_UNIT_WORDS]; /* the core's own image */
    uint32_t sum;                  /* CRC-32 of everything above */
} fmu_image;

#define FMU_IMAGE_BYTES (offsetof(fmu_image, sum) + sizeof(uint32_t)) /* without what may follow as padding */

typedef struct fmu_instance {
    uint32_t magic;
    int32_t mode;
    int32_t has_stop;
    double time; /* where the next step begins: start time, then the end of the last step */
    double stop;
    fmu_unit unit;
    unsigned shown; /* messages that are wanted, a bit a status */
    char name[128];
    void *environment;
    void (*say)(const struct fmu_instance *fmu, int status, const char *category, const char *message);
    void (*log)(void); /* the importer's function behind `say`, of a type that depends on the version */
    void *(*allocate)(size_t count, size_t size);
    void (*release)(void *memory);
} fmu_instance;

static const char *const fmu_category[] = {"", "logStatusWarning", "logStatusDiscard", "logStatusError"};
static const char *const fmu_mode_name[] = {"instantiated", "in initialization mode", "in step mode", "terminated"};

/* ---- Messages. */

static int fmu_say(const fmu_instance *fmu, int status, const char *format, ...)
{
    char text[320];
    va_list values;
    if (!fmu->log || !(fmu->shown & (1u << status))) {
        return status;
    }
    va_start(values, format);
    (void)vsnprintf(text, sizeof text, format, values);
    va_end(values);
    fmu->say(fmu, status, fmu_category[status], text);
    return status;
}

/* Errors are always shown: a refusal without its reason helps nobody. */
static unsigned fmu_wanted(int on)
{
    return on ? (unsigned)FMU_ALL_MESSAGES : 1u << FMU_ERROR;
}

static int fmu_log_categories(fmu_instance *fmu, int on, size_t count, const char *const *names)
{
    unsigned chosen = 0;
    if (count && !names) {
        return fmu_say(fmu, FMU_ERROR, "SetDebugLogging: %lu categories, but no names", (unsigned long)count);
    }
    for (size_t i = 0; i < count; ++i) {
        unsigned found = 0;
        for (int status = FMU_WARNING; status <= FMU_ERROR; ++status) {
            found |= names[i] && !strcmp(names[i], fmu_category[status]) ? 1u << status : 0u;
        }
        found |= names[i] && !strcmp(names[i], "logAll") ? (unsigned)FMU_ALL_MESSAGES : 0u;
        if (!found) {
            return fmu_say(fmu, FMU_ERROR, "SetDebugLogging: no category '%.60s'", names[i] ? names[i] : "(null)");
        }
        chosen |= found;
    }
    chosen = count ? chosen : (unsigned)FMU_ALL_MESSAGES;
    fmu->shown = (on ? fmu->shown | chosen : fmu->shown & ~chosen) | 1u << FMU_ERROR;
    return FMU_OK;
}

/* ---- Checks. */

static int fmu_finite(double x)
{
    uint64_t bits;
    memcpy(&bits, &x, sizeof bits); /* by pattern: no compiler option can take it away */
    return ((bits >> 52) & 0x7ffu) != 0x7ffu;
}

static double fmu_size(double x)
{
    return x < 0 ? -x : x;
}

static uint32_t fmu_sum(const void *data, size_t size)
{
    const unsigned char *bytes = (const unsigned char *)data;
    uint32_t sum = 0xffffffffu;
    for (size_t i = 0; i < size; ++i) {
        sum ^= bytes[i];
        for (int bit = 0; bit < 8; ++bit) {
            sum = (sum >> 1) ^ (sum & 1u ? 0xedb88320u : 0u);
        }
    }
    return ~sum;
}

static fmu_instance *fmu_known(void *instance)
{
    fmu_instance *fmu = (fmu_instance *)instance;
    return fmu && fmu->magic == FMU_MAGIC ? fmu : NULL;
}

/* The instance in one of these modes (a bit each), or null with a message. */
static fmu_instance *fmu_in(void *instance, unsigned modes, const char *call)
{
    fmu_instance *fmu = fmu_known(instance);
    if (fmu && !(modes & (1u << fmu->mode))) {
        (void)fmu_say(fmu, FMU_ERROR, "%s is not allowed: the FMU is %s", call, fmu_mode_name[fmu->mode]);
        return NULL;
    }
    return fmu;
}

/* ---- Life of an instance. */

static void fmu_begin(fmu_instance *fmu)
{
    fmu->mode = FMU_INSTANTIATED;
    fmu->has_stop = 0;
    fmu->time = 0;
    fmu->stop = 0;
    fmu_unit_start(&fmu->unit);
}

/* `fmu` is zeroed memory. */
static void fmu_made(fmu_instance *fmu, const char *name, int logging)
{
    fmu->magic = FMU_MAGIC;
    fmu->shown = fmu_wanted(logging);
    (void)snprintf(fmu->name, sizeof fmu->name, "%s", name ? name : "");
    fmu_begin(fmu);
}

static int fmu_set_times(fmu_instance *fmu, double start, int has_stop, double stop)
{
    if (!fmu_finite(start) || (has_stop && (!fmu_finite(stop) || stop < start))) {
        return fmu_say(fmu, FMU_ERROR, "start time %g and stop time %g are no times", start, stop);
    }
    fmu->time = start;
    fmu->has_stop = has_stop ? 1 : 0;
    fmu->stop = has_stop ? stop : 0;
    return FMU_OK;
}

/* ---- Variables. */

/* FMU_OK if all references are variables of this type, together `values` long, and may be written if they shall. */
static int fmu_check(fmu_instance *fmu, int type, int writing, const uint32_t *reference, size_t count,
                     const void *value, size_t values)
{
    size_t total = 0;
    if (count && (!reference || !value)) {
        return fmu_say(fmu, FMU_ERROR, "value references or values are a null pointer");
    }
    for (size_t i = 0; i < count; ++i) {
        const fmu_variable *v = reference[i] < FMU_VARIABLES ? &fmu_variables[reference[i]] : NULL;
        if (!v || v->type != type) {
            return fmu_say(fmu, FMU_ERROR, "no variable of this type has the value reference %lu",
                           (unsigned long)reference[i]);
        }
        if (writing && v->role != FMU_INPUT && v->role != FMU_PARAMETER) {
            return fmu_say(fmu, FMU_ERROR, "the variable with value reference %lu is no input and no parameter: it cannot be set",
                           (unsigned long)reference[i]);
        }
        total += v->length;
    }
    if (total != values) {
        return fmu_say(fmu, FMU_ERROR, "%lu values given for variables with %lu", (unsigned long)values,
                       (unsigned long)total);
    }
    return FMU_OK;
}

static double fmu_value(const fmu_instance *fmu, const fmu_variable *v, uint32_t k)
{
    return v->role == FMU_TIME       ? fmu->time
           : v->role == FMU_CONSTANT ? fmu_constants[v->place + k]
           : v->role == FMU_LOCAL    ? fmu_unit_local(&fmu->unit, v->place + k)
                                     : fmu->unit.real[v->place + k];
}

/* Of type FMU_REAL, doubles, or FMU_SINGLE, floats. */
static int fmu_get_real(fmu_instance *fmu, int type, const uint32_t *reference, size_t count, void *value, size_t values)
{
    const int status = fmu_check(fmu, type, 0, reference, count, value, values);
    size_t n = 0;
    for (size_t i = 0; i < count && status == FMU_OK; ++i) {
        const fmu_variable *v = &fmu_variables[reference[i]];
        for (uint32_t k = 0; k < v->length; ++k, ++n) {
            if (type == FMU_SINGLE) {
                ((float *)value)[n] = (float)fmu_value(fmu, v, k);
            } else {
                ((double *)value)[n] = fmu_value(fmu, v, k);
            }
        }
    }
    return status;
}

static double fmu_given(int type, const void *value, size_t i)
{
    return type == FMU_SINGLE ? (double)((const float *)value)[i] : ((const double *)value)[i];
}

/* An input may be anything: the core's guard judges it. A parameter that cannot be is refused, and all others with it. */
static int fmu_set_real(fmu_instance *fmu, int type, const uint32_t *reference, size_t count, const void *value,
                        size_t values)
{
    int status = fmu_check(fmu, type, 1, reference, count, value, values);
    for (size_t i = 0; i < count && status == FMU_OK; ++i) {
        const fmu_variable *v = &fmu_variables[reference[i]];
        if (v->role == FMU_PARAMETER && !fmu_unit_takes(v->place, fmu_given(type, value, i))) {
            status = fmu_say(fmu, FMU_ERROR, "the parameter with value reference %lu cannot be %g: " FMU_REFUSES,
                             (unsigned long)reference[i], fmu_given(type, value, i));
        }
    }
    for (size_t i = 0; i < count && status == FMU_OK; ++i) {
        fmu->unit.real[fmu_variables[reference[i]].place] = fmu_given(type, value, i);
    }
    return status;
}

static int fmu_ready(fmu_instance *fmu)
{
    return fmu_unit_ready(&fmu->unit)
               ? FMU_OK
               : fmu_say(fmu, FMU_ERROR, "parameters contradict each other: " FMU_REFUSES);
}

/* The state is that of the start, and steps may follow. */
static int fmu_go(fmu_instance *fmu)
{
    const int status = fmu_ready(fmu);
    if (status == FMU_OK) {
        fmu_unit_reset(&fmu->unit);
        fmu->mode = FMU_STEPPING;
    }
    return status;
}

/* ---- Step. */

/* Number of samples in a communication step; 0 with a message if it is none that this FMU can make. */
static int32_t fmu_samples(const fmu_instance *fmu, double length)
{
    if (!(FMU_PERIOD > 0)) {
        return 1;
    }
    const double ratio = length / FMU_PERIOD;
    const int32_t samples = ratio < FMU_MOST_PERIODS + 0.5 ? (int32_t)(ratio + 0.5) : 0;
    if (samples < 1 || fmu_size(ratio - samples) > 1e-6 * samples) {
        (void)fmu_say(fmu, FMU_DISCARD, "a communication step of %.17g s is no multiple of the period of %.17g s",
                      length, FMU_PERIOD);
        return 0;
    }
    return samples;
}

/* FMU_OK if a step can be made that begins at `time`, as far as times go. What importers' clocks may be off is a few
 * roundings of the time; where these are not far below the step, the same step could pass for the next one. */
static int fmu_check_times(const fmu_instance *fmu, double time, double length)
{
    const double rounding = 4 * DBL_EPSILON * fmu_size(time);
    if (!fmu_finite(time) || !fmu_finite(length) || !(length > 0) || !fmu_finite(time + length)) {
        return fmu_say(fmu, FMU_ERROR, "a step of %g s from %g s on is none", length, time);
    }
    if (rounding > 0.25 * length) {
        return fmu_say(fmu, FMU_ERROR, "a step of %g s from %.17g s on: so late, double precision cannot tell one "
                       "step from the next", length, time);
    }
    if (fmu_size(time - fmu->time) > 1e-6 * length + rounding) {
        return fmu_say(fmu, FMU_ERROR,
                       "a step from %.17g s on, but the last one ended, or the experiment starts, at %.17g s: go back "
                       "with SetFMUState, so that the memory of the hysteresis goes back too",
                       time, fmu->time);
    }
    if (fmu->has_stop && time + length > fmu->stop + 0.5 * length) {
        return fmu_say(fmu, FMU_ERROR, "a step to %.17g s, beyond the stop time %.17g s", time + length, fmu->stop);
    }
    return FMU_OK;
}

static int fmu_step(fmu_instance *fmu, double time, double length)
{
    if (fmu_check_times(fmu, time, length) != FMU_OK || fmu_ready(fmu) != FMU_OK) {
        return FMU_ERROR;
    }
    const int32_t samples = fmu_samples(fmu, length);
    if (!samples) {
        return FMU_DISCARD;
    }
    for (int32_t k = 0; k < samples; ++k) {
        const char *news = fmu_unit_step(&fmu->unit);
        if (news) {
            (void)fmu_say(fmu, FMU_WARNING, "at %.17g s: %s", time, news);
        }
    }
    fmu->time = time + length;
    return FMU_OK;
}

/* ---- State: kept in the form in which it is serialised. */

static void fmu_take(const fmu_instance *fmu, fmu_image *image)
{
    memset(image, 0, sizeof *image);
    image->magic = FMU_MAGIC;
    image->content = FMU_CONTENT;
    image->mode = fmu->mode;
    image->has_stop = fmu->has_stop;
    image->time = fmu->time;
    image->stop = fmu->stop;
    memcpy(image->real, fmu->unit.real, sizeof image->real);
    memcpy(image->whole, fmu->unit.whole, sizeof image->whole);
    memcpy(image->truth, fmu->unit.truth, sizeof image->truth);
    fmu_unit_save(&fmu->unit, image->unit);
    image->sum = fmu_sum(image, offsetof(fmu_image, sum));
}

static int fmu_image_good(const fmu_image *image)
{
    int good = image->magic == FMU_MAGIC && image->content == FMU_CONTENT &&
               image->sum == fmu_sum(image, offsetof(fmu_image, sum)) && image->mode >= FMU_INSTANTIATED &&
               image->mode <= FMU_TERMINATED && fmu_finite(image->time) && fmu_finite(image->stop);
    for (int i = 0; i < FMU_TRUTHS; ++i) {
        good = good && (image->truth[i] == 0 || image->truth[i] == 1);
    }
    return good;
}

static int fmu_restore(fmu_instance *fmu, const fmu_image *image)
{
    if (!image || !fmu_image_good(image) || !fmu_unit_restore(&fmu->unit, image->unit)) {
        return fmu_say(fmu, FMU_ERROR, "the state is damaged or belongs to another FMU: nothing was restored");
    }
    fmu->mode = image->mode;
    fmu->has_stop = image->has_stop;
    fmu->time = image->time;
    fmu->stop = image->stop;
    memcpy(fmu->unit.real, image->real, sizeof image->real);
    memcpy(fmu->unit.whole, image->whole, sizeof image->whole);
    memcpy(fmu->unit.truth, image->truth, sizeof image->truth);
    return FMU_OK;
}

/* Into *kept, whose memory is used again if there is some. */
static int fmu_keep(fmu_instance *fmu, void **kept)
{
    if (!kept) {
        return fmu_say(fmu, FMU_ERROR, "GetFMUState: no place for the state");
    }
    if (!*kept) {
        *kept = fmu->allocate(1, sizeof(fmu_image));
    }
    if (!*kept) {
        return fmu_say(fmu, FMU_ERROR, "GetFMUState: no memory");
    }
    fmu_take(fmu, (fmu_image *)*kept);
    return FMU_OK;
}

static int fmu_drop(fmu_instance *fmu, void **kept)
{
    if (!kept) {
        return fmu_say(fmu, FMU_ERROR, "FreeFMUState: no state");
    }
    if (*kept) {
        fmu->release(*kept);
        *kept = NULL;
    }
    return FMU_OK;
}

static int fmu_serialize(fmu_instance *fmu, const void *kept, void *bytes, size_t size)
{
    if (!kept || !bytes || size < FMU_IMAGE_BYTES) {
        return fmu_say(fmu, FMU_ERROR, "SerializeFMUState: no state, no memory, or fewer than %lu bytes",
                       (unsigned long)FMU_IMAGE_BYTES);
    }
    memcpy(bytes, kept, FMU_IMAGE_BYTES);
    return FMU_OK;
}

static int fmu_deserialize(fmu_instance *fmu, const void *bytes, size_t size, void **kept)
{
    if (!bytes || !kept || size != FMU_IMAGE_BYTES) {
        return fmu_say(fmu, FMU_ERROR, "DeserializeFMUState: nothing given, or not %lu bytes",
                       (unsigned long)FMU_IMAGE_BYTES);
    }
    fmu_image *image = (fmu_image *)fmu->allocate(1, sizeof(fmu_image));
    if (!image) {
        return fmu_say(fmu, FMU_ERROR, "DeserializeFMUState: no memory");
    }
    memcpy(image, bytes, FMU_IMAGE_BYTES);
    if (!fmu_image_good(image)) {
        fmu->release(image);
        return fmu_say(fmu, FMU_ERROR, "DeserializeFMUState: the bytes are damaged or belong to another FMU");
    }
    *kept = image; /* only written: it need not have had a value */
    return FMU_OK;
}

#endif
