/* SPDX-License-Identifier: GPL-2.0 */
/*
 * /dev/plenum-plant: the side of the emulated front end that the chambers are on.
 *
 * read() waits for the next conversion and gives what the board does to the world since the last read; write() sets
 * what the converter's inputs carry from the next conversion on. One opener at a time. Both take the whole record and
 * nothing else (EINVAL).
 */
#ifndef PLENUM_PLANT_DOOR_H
#define PLENUM_PLANT_DOOR_H

#include <linux/types.h>

#define PLANT_DOOR_INPUTS 17 /* 8 pressures, 8 positions, supply: the order of the board's analog inputs */
#define PLANT_DOOR_OUTPUTS 8
#define PLANT_DOOR_INPUT_SPAN_V 20  /* -10 V .. 10 V over the 2^16 codes of two's complement */
#define PLANT_DOOR_OUTPUT_SPAN_V 10 /* 0 V .. 10 V over the 2^16 codes */

/* What read() gives. */
struct plant_door_board {
	__u64 elapsed_ns; /* whole conversion periods since the last read, 0 at the first */
	__u16 output[PLANT_DOOR_OUTPUTS]; /* code at the pin; 0 while the channel is powered down */
	__u32 valve_power; /* 1: the line that switches the valves' supply is high */
	__u32 emergency_stop; /* 1: the line of the emergency stop is high */
};

/* What write() takes. */
struct plant_door_world {
	__s16 input[PLANT_DOOR_INPUTS]; /* code of each converter input */
};

#endif
