/* Sentences to the importer's logger. A refused call changes nothing and says why.

   FMI 2.0 section 2.1.3: with fmi2Warning, fmi2Discard and worse the FMU has called `logger`, whether or not debug
   logging is on. There are no debug messages, so loggingOn only decides whether a choice of categories is heeded. */

#define SENTENCE 512

static const char *const CATEGORIES[] = {"logStatusWarning", "logStatusDiscard", "logStatusError", "logStatusFatal",
                                         "logAll"};
enum { N_CATEGORIES = sizeof CATEGORIES / sizeof CATEGORIES[0] };
#define ALL_CATEGORIES ((1u << N_CATEGORIES) - 1)

/* Returns `status`. The sentence goes out as the logger's format, for there are importers that print the format
   alone; so it may hold none of the characters that mean something there. */
static Status say(const Host *host, unsigned logged, const char *name, Status status, const char *format,
                  va_list arguments)
{
    char sentence[SENTENCE];
    unsigned category = (unsigned)status - (unsigned)WARNING;
    if (!host->logger || !(logged & (1u << category)))
        return status;
    vsnprintf(sentence, sizeof sentence, format, arguments);
    for (char *at = sentence; *at; at++)
        if (*at == '%' || *at == '#')
            *at = '?';
    host->tell(host, name, status, CATEGORIES[category], sentence);
    return status;
}

static Status refuse(const Instance *instance, Status status, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    say(&instance->host, instance->logged, instance->name, status, format, arguments);
    va_end(arguments);
    return status;
}

/* A number as Python shows it: where it is not finite, C libraries differ. */
static const char *number(char text[32], double value)
{
    if (is_finite(value))
        snprintf(text, 32, "%.6g", value);
    else
        strcpy(text, value != value ? "nan" : value > 0 ? "inf" : "-inf");
    return text;
}

/* Why `value` may not stand for `v`, written to `reason`; or 0. */
static int out_of_range(char reason[SENTENCE], const Variable *v, double value)
{
    char text[32], bound[32];
    int below = value < v->minimum;
    if (!is_finite(value)) {
        snprintf(reason, SENTENCE, "%s = %s is not a finite number", v->name, number(text, value));
        return 1;
    }
    if (!below && value <= v->maximum)
        return 0;
    snprintf(reason, SENTENCE, "%s = %s%s is %s its %s %s%s", v->name, number(text, value * v->shown), v->unit,
             below ? "below" : "above", below ? "minimum" : "maximum",
             number(bound, (below ? v->minimum : v->maximum) * v->shown), v->unit);
    return 1;
}

/* A question about the input `v` if `value` is outside its range, written to `question`; or 0. Importers write zeros
   where nothing is wired, and some do before they have the values. */
static int unwired(char question[SENTENCE], const Variable *v, double value)
{
    char text[32];
    if (!out_of_range(question, v, value))
        return 0;
    snprintf(question, SENTENCE, "%s = %s%s: is it wired?", v->name, number(text, value * v->shown), v->unit);
    return 1;
}
