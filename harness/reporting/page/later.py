"""Parts of the page that stand in it as data, and are drawn when a reader comes to them."""

import re
from collections.abc import Callable

from markupsafe import Markup, escape


class Later:
    """Keeps the HTML of parts, and leaves an empty element for each: in templates `{% call later() %}...{% endcall %}`.

    Before, a page of all cases had 45 000 elements, and a browser made each of them before it showed the first.
    """

    def __init__(self) -> None:
        self.parts: dict[str, str] = {}
        """By the number of the part."""

    def __call__(self, tag: str = "div", *, caller: Callable[[], str], **attributes: str) -> Markup:
        name = str(len(self.parts))
        self.parts[name] = re.sub(r">\s*\n\s*<", ">\n<", str(caller()).strip())
        shown = "".join(f' {key}="{escape(value)}"' for key, value in attributes.items())
        return Markup(f'<{tag}{shown} data-part="{name}"></{tag}>')
