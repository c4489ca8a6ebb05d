module bw_json
  !! JSON (RFC 8259) of texts and numbers, and of lists and objects composed of them.
  use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
  use bw_kinds, only: dp
  use bw_missing, only: is_missing
  use bw_text, only: read_letter, string, text_builder, text_of
  implicit none (type, external)
  private
  public :: json_list, json_member, json_number, json_text, json_texts

contains

  pure function json_text(text) result(quoted)
    !! Quote a text. Invisible letters and terminal controls are escaped, so that the document is one line of printable
    !! letters. A byte that is not UTF-8, as in names of files, becomes a lone surrogate U+DC80 … U+DCFF, as in Python
    !! (PEP 383).
    character(*), intent(in) :: text
    character(:), allocatable :: quoted
    type(text_builder) :: builder
    integer :: code, i, length
    logical :: plain
    call builder%append('"')
    i = 1
    do while (i <= len(text))
      call read_letter(text(i:min(len(text), i + 3)), length, plain, code)
      if (text(i:i) == '"' .or. text(i:i) == '\') then
        call builder%append('\'//text(i:i))
      else if (plain .and. text(i:i) /= new_line('a') .and. iachar(text(i:i)) /= 9) then
        call builder%append(text(i:i + length - 1))
      else if (code >= int(z'10000')) then
        call builder%append(unit_of(int(z'D800') + (code - int(z'10000'))/1024)//unit_of(int(z'DC00') + mod(code, 1024)))
      else if (length == 1 .and. code >= 128) then
        call builder%append(unit_of(int(z'DC00') + code))
      else
        call builder%append(unit_of(code))
      end if
      i = i + length
    end do
    call builder%append('"')
    quoted = builder%text()
  end function json_text

  pure function unit_of(code) result(escape)
    !! Return a UTF-16 code unit: `\u001b`.
    integer, intent(in) :: code
    character(6) :: escape
    write (escape, '(a, z4.4)') '\u', code
  end function unit_of

  pure function json_number(value) result(text)
    !! Return a real as the shortest text that reads back to the same bits; `null` if it is missing.
    real(dp), intent(in) :: value
    character(:), allocatable :: text
    text = 'null'
    if (.not. ieee_is_finite(value)) return
    if (.not. is_missing(value)) text = text_of(value)
  end function json_number

  pure function json_member(name, value) result(member)
    !! Return a member of an object, preceded by a comma: `, "name": value`.
    character(*), intent(in) :: name
    character(*), intent(in) :: value        !! JSON
    character(:), allocatable :: member
    member = ', "'//name//'": '//value
  end function json_member

  pure function json_texts(texts) result(list)
    !! Return a list of texts.
    type(string), intent(in) :: texts(:)
    character(:), allocatable :: list
    type(string) :: values(size(texts))
    integer :: i
    do i = 1, size(texts)
      values(i)%text = json_text(texts(i)%text)
    end do
    list = json_list(values)
  end function json_texts

  pure function json_list(values) result(list)
    !! Return a list of JSON values.
    type(string), intent(in) :: values(:)    !! JSON
    character(:), allocatable :: list
    type(text_builder) :: builder
    integer :: i
    call builder%append('[')
    do i = 1, size(values)
      if (i > 1) call builder%append(', ')
      call builder%append(values(i)%text)
    end do
    call builder%append(']')
    list = builder%text()
  end function json_list

end module bw_json
