#include <stdio.h>
#include <stdlib.h>

#include "io.h"

void io_read(void *to, uint32_t bytes)
{
    static FILE *job;
    if (!job) job = fopen("job.bin", "rb");
    if (!job || fread(to, 1, bytes, job) != bytes) io_end(2);
}

void io_write(const void *from, uint32_t bytes)
{
    static FILE *answer;
    if (!answer) answer = fopen("answer.bin", "wb");
    if (!answer || fwrite(from, 1, bytes, answer) != bytes) io_end(3);
}

void io_end(int status) { exit(status); }
