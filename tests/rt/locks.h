/* List of the C library's lock functions, for a preloaded library that observes their callers:
 * included once, where LOCK(name, parameters, arguments) defines a function that observes the call
 * and passes it on. */
#include <pthread.h>
#include <semaphore.h>
#include <time.h>

LOCK(pthread_mutex_lock, (pthread_mutex_t * m), (m))
LOCK(pthread_mutex_trylock, (pthread_mutex_t * m), (m))
LOCK(pthread_mutex_timedlock, (pthread_mutex_t * m, const struct timespec *t), (m, t))
LOCK(pthread_rwlock_rdlock, (pthread_rwlock_t * l), (l))
LOCK(pthread_rwlock_wrlock, (pthread_rwlock_t * l), (l))
LOCK(pthread_cond_signal, (pthread_cond_t * c), (c))
LOCK(pthread_cond_broadcast, (pthread_cond_t * c), (c))
LOCK(pthread_cond_wait, (pthread_cond_t * c, pthread_mutex_t *m), (c, m))
LOCK(sem_wait, (sem_t * s), (s))
LOCK(sem_post, (sem_t * s), (s))
