"""Another maker's device (pymodbus) in the plant's place: a machine that stands still at 1.43 m. Prints its port; serves until killed."""
import asyncio
from pymodbus.datastore import ModbusSequentialDataBlock, ModbusServerContext, ModbusSlaveContext
from pymodbus.server import ModbusTcpServer

SUPPLY, COMMAND, SAMPLE, LENGTH, INPUTS, END = 0x001E, 0x001F, 0x0020, 0x0022, 0x003B, 0x003C


class Machine(ModbusSequentialDataBlock):
    """Counts a sample whenever the readings are read. Its supply has pressure while the output for it toggles."""

    level, still = 0, 99

    def getValues(self, address, count=1):
        if address == COMMAND:
            level = super().getValues(SUPPLY, 1)[0]
            self.still = 0 if level != self.level else self.still + 1
            self.level = level
            self.setValues(INPUTS, [0x0F if self.still < 5 else 0x87])  # plain in the low bits, inverse in the high ones
            self.setValues(SAMPLE, [(super().getValues(SAMPLE, 1)[0] + 1) & 0xFFFF])
        return super().getValues(address, count)


async def main():
    registers = [0] * END
    registers[0:2] = [0x4845, 3]
    for leg in range(6):
        registers[LENGTH + 2 * leg:LENGTH + 2 * leg + 2] = divmod(1431000, 1 << 16)
    machine = Machine(0, registers)
    context = ModbusServerContext(slaves=ModbusSlaveContext(hr=machine, zero_mode=True), single=True)
    server = ModbusTcpServer(context, address=("127.0.0.1", 0))
    serving = asyncio.create_task(server.serve_forever())
    while not getattr(server, "transport", None):
        await asyncio.sleep(0.01)
    print(server.transport.sockets[0].getsockname()[1], flush=True)
    await serving


asyncio.run(main())
