"""Sessions with `canvass lsp`, had by pytest-lsp with what editors say that they can do.

`tests/peers/language_server.rs` runs this by pytest; the variable CANVASS names the program. What pytest-lsp finds
against the protocol in an answer is an error here.
"""

import os
import pathlib
import subprocess

import pytest
import pytest_lsp
from lsprotocol import types as lsp
from pytest_lsp import ClientServerConfig, LanguageClient, client_capabilities

CANVASS = os.environ["CANVASS"]
EDITORS = ["visual-studio-code", "neovim@v0.11.0", "neovim@v0.6.1", "emacs"]
PUBLISHED = "textDocument/publishDiagnostics"
URI = "file:///work/encoder.eds"
TEXT = """\
; Zähler 😀
[DeviceInfo]
VendorName=Example
LSS_Supported=yes

[OptionalObjects]
SupportedObjects=7
1=0x1018

[1018]
ParameterName=Identity
ObjectType=0x9
SubNumber=2

[1018sub0]
ParameterName=Highest
DataType=0x0005
AccessType=ro
DefaultValue=1

[1018sub1]
ParameterName=Vendor-ID
DataType=0x0007
AccessType=ro
"""


@pytest_lsp.fixture(params=EDITORS, config=ClientServerConfig(server_command=[CANVASS, "lsp"]))
async def client(request, lsp_client: LanguageClient):
    capabilities = client_capabilities(request.param)
    params = lsp.InitializeParams(capabilities=capabilities, process_id=os.getpid(), root_uri="file:///work")
    begun = await lsp_client.initialize_session(params)
    assert begun.server_info.name == "canvass"
    yield
    await lsp_client.shutdown_session()


async def opened(client: LanguageClient, text: str = TEXT) -> list[lsp.Diagnostic]:
    """Opens a file, and gives its findings."""
    document = lsp.TextDocumentItem(uri=URI, language_id="eds", version=1, text=text)
    client.text_document_did_open(lsp.DidOpenTextDocumentParams(text_document=document))
    return (await client.wait_for_notification(PUBLISHED)).diagnostics


def named() -> lsp.TextDocumentIdentifier:
    return lsp.TextDocumentIdentifier(uri=URI)


def line_of(start: str) -> int:
    return next(number for number, line in enumerate(TEXT.splitlines()) if line.startswith(start))


def place(start: str, character: int) -> lsp.Position:
    return lsp.Position(line=line_of(start), character=character)


def with_edits(text: str, edits: list[lsp.TextEdit]) -> str:
    """The text after edits that do not overlap. All that they touch is ASCII."""
    lines = text.splitlines(keepends=True)

    def offset(position: lsp.Position) -> int:
        return sum(len(line) for line in lines[: position.line]) + position.character

    for edit in sorted(edits, key=lambda edit: offset(edit.range.start), reverse=True):
        text = text[: offset(edit.range.start)] + edit.new_text + text[offset(edit.range.end) :]
    return text


@pytest.mark.asyncio
async def test_findings_follow_what_is_typed(client: LanguageClient):
    found = await opened(client)
    count = next(one for one in found if one.code == "eds/list/count")
    assert (count.severity, count.source) == (lsp.DiagnosticSeverity.Warning, "canvass")
    line = line_of("SupportedObjects")
    assert count.range == lsp.Range(lsp.Position(line, 17), lsp.Position(line, 18))
    changed = lsp.VersionedTextDocumentIdentifier(uri=URI, version=2)
    change = lsp.TextDocumentContentChangePartial(range=count.range, text="1")
    client.text_document_did_change(lsp.DidChangeTextDocumentParams(changed, [change]))
    then = await client.wait_for_notification(PUBLISHED)
    codes = [one.code for one in then.diagnostics]
    assert then.version == 2 and codes and "eds/list/count" not in codes
    client.text_document_did_close(lsp.DidCloseTextDocumentParams(named()))
    assert not (await client.wait_for_notification(PUBLISHED)).diagnostics


@pytest.mark.asyncio
async def test_places_are_told_what_they_are(client: LanguageClient):
    await opened(client)
    shown = await client.text_document_hover_async(lsp.HoverParams(named(), place("[1018sub1]", 3)))
    assert "Vendor-ID" in shown.contents.value
    goes = await client.text_document_definition_async(lsp.DefinitionParams(named(), place("1=0x1018", 4)))
    assert goes.range.start == place("[1018]", 1)
    context = lsp.ReferenceContext(include_declaration=True)
    asked = lsp.ReferenceParams(context, named(), place("[1018]", 2))
    assert len(await client.text_document_references_async(asked)) == 4
    outline = await client.text_document_document_symbol_async(lsp.DocumentSymbolParams(named()))
    identity = next(symbol for symbol in outline if symbol.name == "1018")
    assert identity.detail == "Identity" and [entry.name for entry in identity.children] == ["1018sub0", "1018sub1"]


@pytest.mark.asyncio
async def test_what_may_come_next(client: LanguageClient):
    await opened(client)
    asked = lsp.CompletionParams(named(), place("LSS_Supported", 14))
    offered = await client.text_document_completion_async(asked)
    assert [item.label for item in offered] == ["0", "1"]
    assert all(item.text_edit.range.start == place("LSS_Supported", 14) for item in offered)


@pytest.mark.asyncio
async def test_what_mends_is_what_the_command_does(client: LanguageClient, tmp_path: pathlib.Path):
    found = await opened(client)
    count = next(one for one in found if one.code == "eds/list/count")
    asked = lsp.CodeActionParams(named(), count.range, lsp.CodeActionContext(diagnostics=[count]))
    actions = await client.text_document_code_action_async(asked)
    assert [action.title for action in actions][:1] == ["write 1"]
    assert actions[0].edit.changes[URI][0].new_text == "1"
    options = lsp.FormattingOptions(tab_size=4, insert_spaces=True)
    edits = await client.text_document_formatting_async(lsp.DocumentFormattingParams(named(), options))
    file = tmp_path / "encoder.eds"
    file.write_text(TEXT, encoding="utf-8", newline="")
    subprocess.run([CANVASS, "eds", "check", "--fix", file], check=False, capture_output=True, timeout=60)
    mended = file.read_bytes().decode("utf-8")
    assert with_edits(TEXT, edits) == mended != TEXT
    everything = actions[-1]
    assert everything.kind == lsp.CodeActionKind.SourceFixAll
    if everything.edit is None:
        # Editors that can ask for the edits when somebody chooses the action.
        everything = await client.code_action_resolve_async(everything)
    assert with_edits(TEXT, everything.edit.changes[URI]) == mended
