/* The two files of a driver: on a microcontroller by semihosting, on the host by its C library. */
#ifndef IO_H
#define IO_H

#include <stdint.h>

void io_read(void *to, uint32_t bytes);          /* from job.bin; ends the program if it is too short */
void io_write(const void *from, uint32_t bytes); /* to answer.bin */
void io_end(int status);

#endif
