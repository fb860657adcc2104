/* Memory of a diagnosis. If an allocation fails, the process ends with "out of memory" as after
 * a device error, so that a lack of memory never becomes a failed trial and thus a verdict. Only
 * for a process that moves nothing. Any thread. */
#ifndef HEXID_MEMORY_H
#define HEXID_MEMORY_H

#include <stddef.h>

/* Zeroed; released by free(). */
void *memory_get(size_t count, size_t size);

/* Ends the process; for callers that learn of failed allocations by a status. */
_Noreturn void memory_end(void);

#endif
