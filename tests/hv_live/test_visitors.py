import asyncio
import json

from hv_live.visitors import MOST_TEXTS, Visitor, Visitors


class SlowSocket:
    """Takes what is sent one by one, when it is let."""

    def __init__(self):
        self.sent, self.let = [], asyncio.Semaphore(0)

    async def send_str(self, text):
        await self.let.acquire()
        self.sent.append(json.loads(text))

    async def send_bytes(self, data):
        await self.let.acquire()
        self.sent.append(data)


def test_a_slow_line_gets_what_is_newest():
    async def main():
        socket = SlowSocket()
        visitor = Visitor(socket)
        sending = asyncio.create_task(visitor.keep_sending())
        for number in range(100):
            visitor.offer(bytes([number]))
            visitor.offer({"type": "state", "step": number})
            visitor.offer({"type": "notice", "text": str(number)})
        for _ in range(MOST_TEXTS + 2):
            socket.let.release()
        await asyncio.sleep(0.05)
        sending.cancel()
        return socket.sent

    *texts, state, picture = asyncio.run(main())
    assert [text["text"] for text in texts] == [str(n) for n in range(100 - MOST_TEXTS, 100)]
    assert state == {"type": "state", "step": 99}
    assert picture == bytes([99])


def test_who_came_first_steers_and_then_the_next():
    async def main():
        visitors, first, second = Visitors(), Visitor(SlowSocket()), Visitor(SlowSocket())
        visitors.enter(first)
        visitors.enter(second)
        assert (visitors.steers(first), visitors.steers(second), len(visitors)) == (True, False, 2)
        visitors.leave(first)
        visitors.leave(first)
        assert (visitors.steers(first), visitors.steers(second), len(visitors)) == (False, True, 1)
        visitors.leave(second)
        assert not visitors.steers(second)

    asyncio.run(main())
