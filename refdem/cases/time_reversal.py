"""Time reversal (1.7): a conservative motion with its velocities flipped runs back to where it came
from.
"""

from refdem.core.case import Instance
from refdem.core.selection import Selection
from refdem.scene.element import Element
from refdem.scene.elements.contact import Contact


def _loses(element: Element) -> bool:
    """True if the element dissipates energy, so that the motion does not run back."""
    if isinstance(element, Contact):
        if element.law == "rigid":
            return element.restitution < 1 or element.friction > 0
        return element.damping > 0 or element.friction > 0
    return not element.reversible


def _reason(instance: Instance) -> str | None:
    """None for a conservative scene, else the first element that is not."""
    for element in instance.scene.elements:
        if _loses(element):
            if element.drives:
                does = "brings energy in"
            else:
                does = "dissipates energy"
            return f"{element.kind} {does}: the motion has no way back"
    return None


CASE = Selection(
    id="time-reversal",
    title="Time reversal of conservative motions",
    words=("reversible", "backwards", "symplectic", "arrow"),
    statement=(
        "Newton's equations of a conservative system do not tell the direction of time. Run"
        " forward, with all velocities flipped at the end, the motion returns to its start; what is"
        " missing on return is the method's own irreversibility."
    ),
    source="Matuttis and Chen 2014, chapter 1, section 1.7",
    check="reversal",
    admits=_reason,
)
