/* What follows from the contracts alone: appended to the annotated copy, calls the core and nothing else. */

/*@ requires readable(pi) && \valid(z + (0 .. pi->n - 1)) && \valid(output) && apart(pi, z);
    requires \separated(output, z + (0 .. pi->n - 1), pi, pi->threshold + (0 .. pi->n - 1));
    requires \separated(output, pi->slope + (0 .. pi->n - 1)) && \separated(output, pi->loading + (0 .. pi->n - 1));
    requires increasing(pi->threshold, pi->n) && admissible(pi->threshold, z, pi->n);
    assigns z[0 .. pi->n - 1], *output;
    ensures band: \result < 2 ==> band(pi->threshold, z, x, pi->n);
    ensures admissible: admissible(pi->threshold, z, pi->n);
*/
int after_a_step(const dehyst_pi *pi, dehyst_real *z, dehyst_real x, dehyst_real low, dehyst_real high,
                 dehyst_real *output)
{
    return dehyst_pi_step(pi, z, x, low, high, output);
}
