/* Reading and writing the lines that gnomon and a program exchange. */

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* The text after "key": in a line. */
static const char *after(const char *line, const char *key) {
    char quoted[64];
    snprintf(quoted, sizeof quoted, "\"%s\": ", key);
    const char *found = strstr(line, quoted);
    return found ? found + strlen(quoted) : "";
}

/* The numbers of a list, or one; those that are not finite are in quotation marks. */
static int numbers(const char *text, double *out, int most) {
    int count = 0;
    char *end;
    for (text += strspn(text, "[ \""); count < most; text = end + strspn(end, ", \"")) {
        out[count] = strtod(text, &end);
        if (end == text) break;
        count++;
    }
    return count;
}

/* Write a state. */
static void write_state(const double *y, int n) {
    for (int i = 0; i < n; i++) {
        printf(i ? ", " : "[");
        printf(isfinite(y[i]) ? "%.17g" : isnan(y[i]) ? "\"nan\"" : y[i] > 0 ? "\"inf\"" : "\"-inf\"", y[i]);
    }
    printf("]");
}
