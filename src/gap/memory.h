/* Memory of a diagnosis. Without it the process ends, "out of memory", as of a device that fails:
 * no lack of it may become a trial that does not fit, and so a verdict. For a process that moves
 * nothing. Any thread. */
#ifndef HEXID_MEMORY_H
#define HEXID_MEMORY_H

#include <stddef.h>

/* Zeroed, for free(). */
void *memory_get(size_t count, size_t size);

/* What it does without; for what says by its status that it had none. */
_Noreturn void memory_end(void);

#endif
