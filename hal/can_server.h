/* SDO server of a node: expedited transfers of CiA 301, 7.2.4. Requests for segments and blocks get
 * an abort, because no object is longer than 4 bytes. Pure. */
#ifndef HEXID_CAN_SERVER_H
#define HEXID_CAN_SERVER_H

#include "can_node.h"

/* Handles a frame to the node's SDO server. The node must be in pre-operational or operational.
 * Aborts from the client and frames that are not 8 bytes long are ignored. */
void can_server_receive(struct can_node *n, const struct can_frame *frame, int64_t now_ns, struct can_queue *out);

#endif
