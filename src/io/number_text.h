/* Converts numbers to text. Any thread. */
#ifndef HEXID_NUMBER_TEXT_H
#define HEXID_NUMBER_TEXT_H

enum { NUMBER_SIZE = 32 };

/* Writes the shortest form that reads back bit for bit, and returns `text`. For any NaN it returns
 * the constant "nan" and leaves `text` alone. */
const char *number_shortest(double number, char text[NUMBER_SIZE]);

#endif
