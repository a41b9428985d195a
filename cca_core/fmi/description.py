"""Descriptions of an FMU as XML, for FMI 2.0 and 3.0."""

from collections.abc import Iterator
from xml.sax.saxutils import quoteattr

from cca_core.codegen.export.model import Model, Variable

_UNITS = {
    "m": "m='1'",
    "m/s": "m='1' s='-1'",
    "m/s2": "m='1' s='-2'",
    "rad": "rad='1'",
    "rad/s": "rad='1' s='-1'",
}
SOURCES = ("model.c", "kernel.c")


def model_description(model: Model, token: str, version: str, step: float) -> str:
    """Return modelDescription.xml."""
    lines = _fmi3(model, token, step) if version == "3.0" else _fmi2(model, token, step)
    return '<?xml version="1.0" encoding="UTF-8"?>\n' + "\n".join(lines) + "\n"


def build_description(model: Model) -> str:
    """Return sources/buildDescription.xml of FMI 3.0."""
    files = "".join(f'<SourceFile name="{name}"/>' for name in ("fmi3.c", *SOURCES))
    return (
        '<?xml version="1.0" encoding="UTF-8"?>\n<fmiBuildDescription fmiVersion="3.0">\n'
        f'  <BuildConfiguration modelIdentifier="{model.name}">\n'
        f'    <SourceFileSet language="C99">{files}</SourceFileSet>\n'
        "  </BuildConfiguration>\n</fmiBuildDescription>\n"
    )


def _units(model: Model) -> Iterator[str]:
    yield "  <UnitDefinitions>"
    for unit in sorted({v.unit for v in model.variables} | {"s"}):
        base = _UNITS.get(unit, "s='1'")
        yield f'    <Unit name="{unit}"><BaseUnit {base}/></Unit>'
    yield "  </UnitDefinitions>"


def _fmi3(model: Model, token: str, step: float) -> Iterator[str]:
    yield (
        f'<fmiModelDescription fmiVersion="3.0" modelName="{model.name}" '
        f'instantiationToken="{token}" description={quoteattr(model.description)}>'
    )
    yield (
        f'  <CoSimulation modelIdentifier="{model.name}" canHandleVariableCommunicationStepSize="true" '
        f'fixedInternalStepSize="{step!r}"/>'
    )
    yield from _units(model)
    yield f'  <DefaultExperiment startTime="0" stepSize="{step!r}"/>'
    yield "  <ModelVariables>"
    yield (
        '    <Float64 name="time" valueReference="0" causality="independent" variability="continuous" '
        'unit="s"/>'
    )
    for i, v in enumerate(model.variables, 1):
        yield f'    <Float64 name="{v.name}" valueReference="{i}" {_common(v)} unit="{v.unit}" {_start(v)}/>'
    yield "  </ModelVariables>"
    yield "  <ModelStructure>"
    outputs = [i for i, v in enumerate(model.variables, 1) if not v.is_input]
    yield from (f'    <Output valueReference="{i}"/>' for i in outputs)
    yield "  </ModelStructure>"
    yield "</fmiModelDescription>"


def _fmi2(model: Model, token: str, step: float) -> Iterator[str]:
    yield (
        f'<fmiModelDescription fmiVersion="2.0" modelName="{model.name}" guid="{token}" '
        f"description={quoteattr(model.description)}>"
    )
    yield f'  <CoSimulation modelIdentifier="{model.name}" canHandleVariableCommunicationStepSize="true">'
    files = "".join(f'<File name="{name}"/>' for name in ("fmi2.c", *SOURCES))
    yield f"    <SourceFiles>{files}</SourceFiles>"
    yield "  </CoSimulation>"
    yield from _units(model)
    yield f'  <DefaultExperiment startTime="0" stepSize="{step!r}"/>'
    yield "  <ModelVariables>"
    for i, v in enumerate(model.variables, 1):
        yield f'    <ScalarVariable name="{v.name}" valueReference="{i}" {_common(v)}>'
        yield f'      <Real unit="{v.unit}" {_start(v)}/>'
        yield "    </ScalarVariable>"
    yield "  </ModelVariables>"
    outputs = [i for i, v in enumerate(model.variables, 1) if not v.is_input]
    unknowns = "".join(f'<Unknown index="{i}"/>' for i in outputs)
    yield f"  <ModelStructure><Outputs>{unknowns}</Outputs></ModelStructure>"
    yield "</fmiModelDescription>"


def _common(v: Variable) -> str:
    kind = 'causality="input"' if v.is_input else 'causality="output" initial="exact"'
    return f'{kind} variability="discrete" description={quoteattr(v.description)}'


def _start(v: Variable) -> str:
    return f'start="{v.start!r}"'
