/* Bytes at which lines end, and blanks. */
#ifndef DEHYST_ENGINE_TEXT_LINES_H
#define DEHYST_ENGINE_TEXT_LINES_H

static inline int is_end(char c) { return c == '\n' || c == '\r'; }
static inline int is_blank(char c) { return c == ' ' || c == '\t'; }

/* Behind the line end at p. */
static inline const char *behind_end(const char *p, const char *end)
{
    const char *next = p + 1;
    return *p == '\r' && next < end && *next == '\n' ? next + 1 : next;
}

/* The line end at or after p, or the end. */
static inline const char *find_end(const char *p, const char *end)
{
    while (p < end && !is_end(*p)) {
        p++;
    }
    return p;
}

#endif
