#include "dehyst.h"

dehyst_real dehyst_map_value(const dehyst_map *map, dehyst_real u)
{
    if (map->n < 2) {
        return u;
    }
    int32_t left = 0;
    int32_t right = map->n - 1;
    while (right - left > 1) { /* the segment whose left end is the last breakpoint <= u */
        const int32_t middle = left + (right - left) / 2;
        if (map->u[middle] <= u) {
            left = middle;
        } else {
            right = middle;
        }
    }
    const dehyst_real share = (u - map->u[left]) / (map->u[right] - map->u[left]);
    /* From the nearer end: both breakpoints are met exactly, so map and inverse map agree there. */
    return share <= (dehyst_real)0.5
               ? map->v[left] + share * (map->v[right] - map->v[left])
               : map->v[right] - ((map->u[right] - u) / (map->u[right] - map->u[left])) * (map->v[right] - map->v[left]);
}
