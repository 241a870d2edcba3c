/* Rows of numbers as columns: the k-th of `count` rows is the k-th number in each of `width` columns, `length` apart. */
__attribute__((visibility("default")))
void to_columns(const double *rows, unsigned long count, unsigned long width, double *columns, unsigned long length)
{
    for (unsigned long c = 0; c < width; c++)
        for (unsigned long k = 0; k < count; k++)
            columns[c * length + k] = rows[k * width + c];
}
