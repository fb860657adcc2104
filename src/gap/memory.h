/* Memory of a diagnosis. If an allocation fails, the process ends with "out of memory" and the exit
 * status of a device error, so that lack of memory never fails a trial and so changes a verdict.
 * Only for a process that moves nothing. Any thread. */
#ifndef HEXID_MEMORY_H
#define HEXID_MEMORY_H

#include <stddef.h>

/* Allocates zeroed memory, which free() releases. */
void *memory_get(size_t count, size_t size);

/* Ends the process for lack of memory, when a status tells of it. */
_Noreturn void memory_end(void);

#endif
