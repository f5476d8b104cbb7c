/* Constants by which 16 bytes of text become a number; see text_usual.h. */
#ifndef DEHYST_ENGINE_TEXT_TABLES_H
#define DEHYST_ENGINE_TEXT_TABLES_H

/* By the place of the point among the 16 bytes, 16 for none: the bytes without it, moved up, and the power of ten of the
 * digits behind it. */
typedef struct text_place {
    _Alignas(32) signed char order[16];
    double power;
} text_place;

typedef struct text_tables {
    _Alignas(32) signed char zero[16];
    signed char high[16];  /* added to a digit leaves the top bit clear, to anything else sets it */
    signed char pair[16];  /* weights of digits, of pairs and of fours */
    signed char four[16];
    signed char eight[16];
    double upper[2];       /* weights of the upper and lower eight digits */
    double sign[2];
    signed char cell[32];  /* from byte n on: ones in the last n bytes of 16 */
    text_place place[17];
} text_tables;

extern const text_tables text_usual_tables;

#endif
