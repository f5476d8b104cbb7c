/* The choice of a target, in one place: exported folders carry a file of their own.
 *
 * Define DEHYST_FLOAT, here or by the compiler's options, for single precision. */
#ifndef DEHYST_CONFIG_H
#define DEHYST_CONFIG_H

#endif
