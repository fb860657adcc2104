/* Memory of a diagnosis. If an allocation fails, the process ends with "out of memory" and the exit
 * status of a device error, so that a lack of memory can neither fail a trial nor thereby change a
 * verdict. Only for a process that moves nothing. Any thread. */
#ifndef HEXID_MEMORY_H
#define HEXID_MEMORY_H

#include <stddef.h>

/* Returns zeroed memory, never NULL; free() it. */
void *memory_get(size_t count, size_t size);

/* Ends the process for lack of memory, for callers that detect the lack by a status. */
_Noreturn void memory_end(void);

#endif
