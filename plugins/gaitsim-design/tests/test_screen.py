"""The map of designs in the terminal UI."""


async def test_the_cursor_changes_dimensions_and_the_design_walks(mapped, here, drive):
    async with drive() as driver:
        await driver.press("O")
        screen = await driver.at("DesignScreen")
        await driver.until(lambda: screen.canvas.skeleton is not None)
        best = screen.found.best
        assert screen.design == best
        assert "on the plateau" in driver.text("#design")
        await driver.press("left")
        assert screen.found.designs[screen.design, 0] < screen.found.designs[best, 0]
        assert screen.found.designs[screen.design, 1] == screen.found.designs[best, 1]
        await driver.press("c")
        assert screen.quantity == "speed"
        await driver.press("o")
        assert screen.design == screen.found.original
        assert "arm 1 (0.1 m), leg 1 (0.2 m)" in driver.text("#design")
        await driver.until(lambda: len(screen._bodies) > 1)
        assert "designs.axes" not in driver.offered()
        assert screen.command_line() == "gaitsim design runs/crawler-designs"


async def test_a_run_of_another_search_is_explained(finished, here, drive):
    async with drive() as driver:
        await driver.press("O")
        screen = await driver.at("DesignScreen")
        await driver.until(lambda: "not a map of designs" in screen.plot.placeholder())
        assert screen.design is None
