module bw_notes
  !! The collected notes of a scene's cases. In a sweep each kind of note is given once, for its first case, with the
  !! number of other cases that have it and the differing values of the last one. If a case has several of one kind, as of
  !! two sensors, they count as different ones. Warnings precede remarks. Cases may be added in any order.
  use bw_kinds, only: i8
  use bw_note, only: is_remark, kind_of, remark_mark, unmarked
  use bw_text, only: append, string, text_builder, text_of
  implicit none (type, external)
  private

  type :: kind_type
    !! One kind of note.
    integer(i8) :: first = 0                      !! the first case that has it
    integer :: place = 0                          !! its position among the notes of that case
    integer(i8) :: last = 0                       !! the last case that has it
    integer(i8) :: cases = 0                      !! number of cases with it
  end type kind_type

  type, public :: notes_type
    private
    type(kind_type), allocatable :: kinds(:)
    type(string), allocatable :: texts(:)         !! of the first case of each kind
    type(string), allocatable :: last_texts(:)    !! of the last one
  contains
    procedure :: add
    procedure :: lines
  end type notes_type

contains

  pure subroutine add(self, index, notes)
    !! Add the notes of a case.
    class(notes_type), intent(inout) :: self
    integer(i8), intent(in) :: index       !! of the case
    type(string), intent(in) :: notes(:)
    logical, allocatable :: met(:)         !! in this case
    integer :: n, k
    if (.not. allocated(self%kinds)) allocate (self%kinds(0))
    allocate (met(size(self%kinds) + size(notes)), source=.false.)
    do n = 1, size(notes)
      do k = 1, size(self%kinds)
        if (.not. met(k) .and. kind_of(self%texts(k)%text) == kind_of(notes(n)%text)) exit
      end do
      met(k) = .true.
      if (k > size(self%kinds)) then
        self%kinds = [self%kinds, kind_type(index, n, index, 0)]
        call append(self%texts, notes(n)%text)
        call append(self%last_texts, notes(n)%text)
      else if (index < self%kinds(k)%first) then
        self%kinds(k)%first = index
        self%kinds(k)%place = n
        self%texts(k)%text = notes(n)%text
      else if (index > self%kinds(k)%last) then
        self%kinds(k)%last = index
        self%last_texts(k)%text = notes(n)%text
      end if
      self%kinds(k)%cases = self%kinds(k)%cases + 1
    end do
  end subroutine add

  pure function lines(self, cases) result(text)
    !! Return the notes, one line for each kind, warnings first, in the order of their first cases.
    class(notes_type), intent(in) :: self
    integer, intent(in) :: cases           !! of the sweep; 0 if there is none
    character(:), allocatable :: text
    logical, allocatable :: remarks(:)
    integer :: k
    text = ''
    if (.not. allocated(self%kinds)) return
    remarks = [(is_remark(self%texts(k)%text), k=1, size(self%kinds))]
    text = chosen_lines(self, cases, .not. remarks)//chosen_lines(self, cases, remarks)
  end function lines

  pure function chosen_lines(self, cases, chosen) result(text)
    !! Return the notes of selected kinds.
    class(notes_type), intent(in) :: self
    integer, intent(in) :: cases           !! of the sweep; 0 if there is none
    logical, intent(in) :: chosen(:)       !! (kinds)
    character(:), allocatable :: text
    type(text_builder) :: built
    logical :: left(size(chosen))
    integer :: k
    left = chosen
    do while (any(left))
      k = earliest(self%kinds, left)
      left(k) = .false.
      if (is_remark(self%texts(k)%text)) call built%append(remark_mark)
      if (cases > 0) then
        call built%append('case '//text_of(self%kinds(k)%first))
        if (self%kinds(k)%cases == 2) call built%append(' (and one other of '//text_of(cases)//')')
        if (self%kinds(k)%cases > 2) call built%append(' (and '//text_of(self%kinds(k)%cases - 1)//' others of '// &
                                                       text_of(cases)//')')
        call built%append(': ')
      end if
      call built%append(unmarked(self%texts(k)%text))
      if (cases > 0 .and. self%last_texts(k)%text /= self%texts(k)%text) then
        call built%append('; case '//text_of(self%kinds(k)%last)//', the last: '// &
                          what_differs(self%last_texts(k)%text, self%texts(k)%text))
      end if
      call built%append_line('')
    end do
    text = built%text()
  end function chosen_lines

  pure function what_differs(text, first) result(rest)
    !! Return a note without the words at its beginning and the clauses at its end that it shares with the first one of
    !! its kind. If only the value of a symbol differs, as in xi = 0.5, the whole clause is kept.
    character(*), intent(in) :: text, first       !! different texts
    character(:), allocatable :: rest
    integer :: cut, at, begin, clause
    cut = len(text)
    do
      at = max(index(text(:cut), '; ', back=.true.), index(text(:cut), ', ', back=.true.), index(text(:cut), ': ', back=.true.))
      if (at == 0) exit
      if (.not. ends_with(first, text(at:))) exit
      cut = at - 1
    end do
    begin = 0
    clause = 0
    do at = 2, min(len(first), cut)
      if (text(:at) /= first(:at)) exit
      if (text(at:at) == ' ') begin = at
      if (scan(text(at - 1:at - 1), ':;,') > 0) clause = begin
    end do
    if (begin > 1) then
      if (text(begin - 1:begin - 1) == '=') begin = clause
    end if
    rest = text(begin + 1:cut)
  end function what_differs

  pure logical function ends_with(text, ending)
    character(*), intent(in) :: text, ending
    ends_with = len(text) >= len(ending)
    if (ends_with) ends_with = text(len(text) - len(ending) + 1:) == ending
  end function ends_with

  pure integer function earliest(kinds, left) result(k)
    !! Return the index of the kind that comes first among the remaining ones.
    type(kind_type), intent(in) :: kinds(:)
    logical, intent(in) :: left(:)
    integer :: i
    k = findloc(left, .true., dim=1)
    do i = k + 1, size(kinds)
      if (.not. left(i)) cycle
      if (kinds(i)%first < kinds(k)%first .or. &
          (kinds(i)%first == kinds(k)%first .and. kinds(i)%place < kinds(k)%place)) k = i
    end do
  end function earliest

end module bw_notes
