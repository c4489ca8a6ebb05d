module bw_json
  !! Texts and numbers as JSON (RFC 8259) has them, put together into lists and objects by whoever writes one.
  use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
  use bw_kinds, only: dp
  use bw_missing, only: is_missing
  use bw_text, only: read_letter, string, text_builder, text_of
  implicit none (type, external)
  private
  public :: json_list, json_member, json_number, json_text, json_texts

contains

  pure function json_text(text) result(quoted)
    !! A text in quotes. Letters that are not seen or control a terminal are escaped, so that the document is one of printable letters
    !! on one line. A byte that is no UTF-8, as names of files may have it, is a lone surrogate U+DC80 … U+DCFF: what Python makes of such
    !! names itself (PEP 383).
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
    !! A unit of UTF-16: `\u001b`.
    integer, intent(in) :: code
    character(6) :: escape
    write (escape, '(a, z4.4)') '\u', code
  end function unit_of

  pure function json_number(value) result(text)
    !! A real as the shortest text that reads back to the same bits; `null` where it does not exist.
    real(dp), intent(in) :: value
    character(:), allocatable :: text
    text = 'null'
    if (.not. ieee_is_finite(value)) return
    if (.not. is_missing(value)) text = text_of(value)
  end function json_number

  pure function json_member(name, value) result(member)
    !! A member of an object, behind a comma: `, "name": value`.
    character(*), intent(in) :: name
    character(*), intent(in) :: value        !! JSON
    character(:), allocatable :: member
    member = ', "'//name//'": '//value
  end function json_member

  pure function json_texts(texts) result(list)
    !! A list of texts.
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
    !! A list.
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
